"""A whole loop as machine code that steps through all ticks of a run by itself."""

import ctypes

import numpy as np

from drake_mobman.machine_code import assembly, loaded
from drake_mobman.operations import programs
from drake_mobman.step_law import StepLaw

_LOOP = """
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)

define void @run(ptr %state, ptr %commands, ptr %log, i64 %ticks) {{
start:
  %in = alloca double, i64 {taken}
  %out = alloca double, i64 {given}
  %in.command = getelementptr double, ptr %in, i64 {state}
  %out.state = getelementptr double, ptr %out, i64 {outputs}
  call void @llvm.memcpy.p0.p0.i64(ptr %in, ptr %state, i64 {state_bytes}, i1 false)
  br label %tick
tick:
  %k = phi i64 [ 0, %start ], [ %next, %tick ]
  %at = mul i64 %k, {inputs}
  %command = getelementptr double, ptr %commands, i64 %at
  call void @llvm.memcpy.p0.p0.i64(
    ptr %in.command, ptr %command, i64 {input_bytes}, i1 false)
  call void @law0(ptr %in, ptr %out)
  %row = mul i64 %k, {outputs}
  %logged = getelementptr double, ptr %log, i64 %row
  call void @llvm.memcpy.p0.p0.i64(ptr %logged, ptr %out, i64 {output_bytes}, i1 false)
  call void @llvm.memcpy.p0.p0.i64(ptr %in, ptr %out.state, i64 {state_bytes}, i1 false)
  %next = add i64 %k, 1
  %more = icmp slt i64 %next, %ticks
  br i1 %more, label %tick, label %end
end:
  call void @llvm.memcpy.p0.p0.i64(ptr %state, ptr %in, i64 {state_bytes}, i1 false)
  ret void
}}
"""
"""Row k of the log is what the loop puts out at tick k, before its state moves on."""


class Lane:
    """A law that is stepped through the ticks of one run after the other.

    Python's global lock is free meanwhile: several threads step several runs.

    Args:
        law: of a whole loop.
    """

    def __init__(self, law: StepLaw) -> None:
        step, begin = programs(law.trace, [law.step, law.begin])
        state, inputs = len(law.start), sum(x.size for x in law.inputs)
        outputs = sum(x.size for x in law.outputs)
        loop = _LOOP.format(
            taken=state + inputs,
            given=outputs + state,
            state=state,
            inputs=inputs,
            outputs=outputs,
            state_bytes=8 * state,
            input_bytes=8 * inputs,
            output_bytes=8 * outputs,
        )
        self._engine = loaded(assembly([step, begin]) + loop)
        self._outputs = outputs
        pointer = ctypes.c_void_p
        address = self._engine.get_function_address
        self._run = ctypes.CFUNCTYPE(None, *[pointer] * 3, ctypes.c_int64)(
            address("run")
        )
        self._begin = ctypes.CFUNCTYPE(None, *[pointer] * 2)(address("law1"))

    def run(self, start: np.ndarray, commands: np.ndarray) -> np.ndarray:
        """Returns all outputs at each tick (N, outputs).

        Args:
            start: the state before the start (state,).
            commands: inputs at each tick (N, inputs), N above 0.
        """
        commands = np.ascontiguousarray(commands, dtype=float)
        given = np.concatenate([start, commands[0]])
        state = np.empty(len(start))
        self._begin(given.ctypes.data, state.ctypes.data)
        log = np.empty((len(commands), self._outputs))
        self._run(state.ctypes.data, commands.ctypes.data, log.ctypes.data, len(log))
        return log
