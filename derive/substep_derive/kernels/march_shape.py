"""The shape of a linear march: how many numbers it carries, and where in them u, h*v and h^2*a stand."""

LOADS = (2, 4)  # kernels are printed for so many instants a step; fewer are filled up with zeros


Shape = tuple[int, tuple[int, int, int]]


def shape_name(shape: Shape) -> str:
    """Name of its module, such as linear_march_2_01y, or linear_march_12_0_11_y where a place may have two digits."""
    m, places = shape
    between = "_" if m > 10 else ""
    return f"linear_march_{m}_" + between.join(str(place) if place >= 0 else "y" for place in places)


def shape_of(name: str) -> Shape:
    """The shape of the module of that name."""
    _, _, m, *places = name.split("_")
    u, v, a = (-1 if place == "y" else int(place) for place in (places if len(places) == 3 else places[0]))
    return int(m), (u, v, a)


def loads_for(count: int) -> int:
    """How many load instants the kernel has that takes so many."""
    return max(LOADS[0], count + count % 2)
