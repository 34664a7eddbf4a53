"""Fixed text of what is done to several numbers at a time, which the march of small structures is made of."""

SEVERAL_NUMBERS = '''

class _Several(types.Type):
    """WIDTH numbers, of which one instruction takes four or more; LLVM finds few of these itself where loops are short.

    With lanes these are all lanes of one number: no loop over lanes is left, and several sums are on their way at once.
    """

    def __init__(self):
        super().__init__("several")


@register_model(_Several)
class _Vector(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, VECTOR)


VECTOR, SEVERAL, ONE = ir.VectorType(ir.DoubleType(), WIDTH), _Several(), ["contract"]


def _first(context, builder, kind, value):
    """Where the first number of a contiguous array is, or of what a pointer points to."""
    return value if isinstance(kind, types.CPointer) else context.make_array(kind)(context, builder, value).data


@intrinsic
def _part(typing, array, place):
    """Where the number at a place is: to give this to a function takes less time than a part of the array."""

    def lower(context, builder, signature, values):
        return builder.gep(_first(context, builder, array, values[0]), [values[1]])

    return types.CPointer(array.dtype)(array, types.int64), lower


def _address(context, builder, kind, values):
    """Where the numbers from a place on are."""
    first = _first(context, builder, kind, values[0])
    return builder.bitcast(builder.gep(first, [values[1]]), VECTOR.as_pointer())


@intrinsic
def _several(typing, array, place):
    """WIDTH numbers from a place on."""

    def lower(context, builder, signature, values):
        return builder.load(_address(context, builder, array, values), align=8)

    return SEVERAL(array, types.int64), lower


@intrinsic
def _put(typing, array, place, several):
    """Put them there."""

    def lower(context, builder, signature, values):
        builder.store(values[2], _address(context, builder, array, values), align=8)
        return context.get_dummy_value()

    return types.none(array, types.int64, SEVERAL), lower


@intrinsic
def _each(typing, number):
    """One number WIDTH times."""

    def lower(context, builder, signature, values):
        one = builder.insert_element(ir.Constant(VECTOR, ir.Undefined), values[0], ir.IntType(32)(0))
        return builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH))

    return SEVERAL(types.float64), lower


@intrinsic
def _number(typing, several, place):
    """One of several."""
    found = types.float64(SEVERAL, types.int64)
    return found, lambda context, builder, signature, values: builder.extract_element(*values)


def _of_two(build):
    """An operation on two of them."""

    @intrinsic
    def operation(typing, a, b):
        return SEVERAL(SEVERAL, SEVERAL), lambda context, builder, signature, values: build(builder, *values)

    return operation


def _of_three(build):
    """An operation on three of them."""

    @intrinsic
    def operation(typing, a, b, c):
        return SEVERAL(SEVERAL, SEVERAL, SEVERAL), lambda context, builder, signature, values: build(builder, *values)

    return operation


def _larger_modulus(builder, a, b):
    whole = ir.VectorType(ir.IntType(64), WIDTH)
    size = builder.bitcast(builder.and_(builder.bitcast(b, whole), ir.Constant(whole, [2**63 - 1] * WIDTH)), VECTOR)
    return builder.select(builder.fcmp_ordered(">", size, a), size, a)


_times = _of_two(lambda builder, a, b: builder.fmul(a, b))
_over = _of_two(lambda builder, a, b: builder.fdiv(a, b))
_larger = _of_two(_larger_modulus)  # a or |b|
_unfused = _of_three(lambda builder, a, b, c: builder.fadd(a, builder.fmul(b, c)))  # a + b c, each operation rounded
_fused = _of_three(  # as one operation, where there is such a one
    lambda builder, a, b, c: builder.fadd(a, builder.fmul(b, c, flags=ONE), flags=ONE)
)
_unless_more = _of_three(  # 1 where b is not more than c
    lambda builder, a, b, c: builder.select(builder.fcmp_ordered(">", b, c), a, ir.Constant(VECTOR, [1.0] * WIDTH))
)
_unlike = _of_three(  # 1 where b is not c
    lambda builder, a, b, c: builder.select(builder.fcmp_unordered("!=", b, c), ir.Constant(VECTOR, [1.0] * WIDTH), a)
)


@intrinsic
def _some(typing, several):
    """Whether some of them are not 0."""

    def lower(context, builder, signature, values):
        marks = builder.fcmp_unordered("!=", values[0], ir.Constant(VECTOR, [0.0] * WIDTH))
        return builder.icmp_unsigned("!=", builder.bitcast(marks, ir.IntType(WIDTH)), ir.Constant(ir.IntType(WIDTH), 0))

    return types.boolean(SEVERAL), lower
'''
