"""The layout of a thread of a GPU: the text of one lane as code of the device, and a kernel that calls it."""

import re
from collections.abc import Sequence

from ..kernels.body import Body
from .one_lane import given, lane_function, of_lane
from .pair_module import helpers, march_arguments
from .printing import fill
from .step_text import DT, Layout, StepText, step_text
from .templates.step import NEWTON
from .templates.thread import COMPILE_THREADS, LANE_OF_THREAD, PAIR_THREADS_HEADER, SIGN

# NumPy's functions in the text of a step, and what a device has in their place
ON_DEVICE = {"np.sign(": "_sign(", "np.minimum(": "min(", "np.int64(": "int(", "np.": "math."}

ZEROS = r"\1\2 = cuda.local.array(\3, float64)\n\1for place in range(\3):\n\1    \2[place] = 0.0"


def _march(body: Body, step: StepText, arguments: Sequence[str]) -> str:
    """Text of the function for one lane, and of the kernel that calls it in each thread."""
    return lane_function(body, step, arguments) + fill(
        LANE_OF_THREAD,
        arguments=", ".join(arguments),
        scheme=body.scheme.name,
        lane_call=", ".join(of_lane(given(arguments))),
    )


GPU_THREAD = Layout("", NEWTON, "", lambda body: {}, _march)


def pair_threads(body: Body, banner: str) -> str:
    """Text of the module that marches a pair in the threads of a GPU; its start is that of the pair's own module."""
    step = step_text(body, DT, GPU_THREAD, body.results)
    march = GPU_THREAD.march(body, step, march_arguments(body))
    text = on_device("".join([*helpers(march, body), march]))
    header = fill(PAIR_THREADS_HEADER, scheme=body.scheme.name, scene=body.motion.scene.name)
    return "".join([banner, header, COMPILE_THREADS, text])


def on_device(text: str) -> str:
    """Text of functions of a CPU, as code of the device, where each thread has arrays of its own."""
    text, made = re.subn(r"^( *)(\w+) = np\.zeros\((\d+)\)$", ZEROS, text, flags=re.MULTILINE)
    for name, other in ON_DEVICE.items():
        text = text.replace(name, other)
    return "from numba import float64\n" * (made > 0) + SIGN * ("_sign(" in text) + text
