"""The shape of a linear march: how many numbers it carries, and where in them u, h*v and h^2*a stand."""

LEAST_LOADS = 2  # load instants a step of the smallest kernel; a scheme with fewer fills up with zeros
# how many numbers are carried; places of u, h*v and h^2*a among them, -1 for one that is an output of its own
Shape = tuple[int, tuple[int, int, int]]


def shape_name(shape: Shape) -> str:
    """Name of the shape's module, such as linear_march_2_01y, or linear_march_12_0_11_y if places have two digits."""
    m, places = shape
    between = "_" if m > 10 else ""
    return f"linear_march_{m}_" + between.join(str(place) if place >= 0 else "y" for place in places)


def shape_of(name: str) -> Shape:
    """The shape of the module of that name."""
    _, _, m, *places = name.split("_")
    u, v, a = (-1 if place == "y" else int(place) for place in (places if len(places) == 3 else places[0]))
    return int(m), (u, v, a)


def loads_for(count: int) -> int:
    """Number of load instants of the smallest kernel that can take `count` of them."""
    return max(LEAST_LOADS, count + count % 2)
