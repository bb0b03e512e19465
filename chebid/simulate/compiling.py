"""What the compiled part is made with: types of its arrays and of the functions that plug into it, and two tricks."""

from functools import partial
from typing import Any, cast

from numba import float64, int64, njit, types
from numba.core.cgutils import get_null_value
from numba.extending import intrinsic

many: Any = types.UniTuple
vector, matrix, cube = (types.Array(float64, axes, "C") for axes in (1, 2, 3))
indices, table = (types.Array(int64, axes, "C") for axes in (1, 2))

#: (t, q, dq, ddq, tau, joint, p, h) -> torque on the joint, or level of dry friction
FORWARD = float64(float64, vector, vector, vector, vector, int64, vector, vector)
#: (q, dq, p, mass, bias): fills mass (J, J) and bias (J,) of  torque = mass ddq + bias
PLANT = types.void(vector, vector, vector, matrix, vector)

#: for functions called by compiled ones only: without wrappers, which take longer to compile than the rest
jit: Any = partial(cast(Any, njit), error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)()


_intrinsic: Any = intrinsic


@_intrinsic
def borrow(_context: Any, array: Any) -> Any:
    """The same array without reference counting, which would take most of the time; the caller keeps it alive."""

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        bare = context.make_array(signature.args[0])(context, builder, arguments[0])
        for field in ("meminfo", "parent"):
            setattr(bare, field, cast(Any, get_null_value)(getattr(bare, field).type))
        return bare._getvalue()

    return array(array), build
