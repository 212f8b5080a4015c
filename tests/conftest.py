"""What tests of blocks share: blocks fed by hand, without a diagram."""

import os
import shutil
import tempfile

import numpy as np
import pytest
from hypothesis import settings

# The same examples in each run, and none fails for a busy machine.
settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.load_profile("repeatable")


def pytest_configure(config):
    """Lets all processes of a session share what Python compiled, and removes it.

    Some machines tell Python to write none of it. Each of the hundred processes that
    the tests start would compile the package anew, in a quarter of a second.
    """
    if hasattr(config, "workerinput"):  # It has its environment of the one above.
        return
    compiled = tempfile.mkdtemp(prefix="pycache-")
    config.add_cleanup(lambda: shutil.rmtree(compiled, ignore_errors=True))
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ["PYTHONPYCACHEPREFIX"] = compiled


@pytest.fixture(scope="session")
def fed():
    """A function that returns a context of `block` with `inputs` by port name."""

    def context_of(block, state=None, **inputs):
        context = block.CreateDefaultContext()
        for name, value in inputs.items():
            block.GetInputPort(name).FixValue(context, np.array(value))
        if state is not None:
            context.SetDiscreteState(np.array(state))
        return context

    return context_of


@pytest.fixture(scope="session")
def outputs():
    """A function that returns a block's outputs (size,) in a context, by port name."""

    def outputs_of(block, context):
        ports = map(block.get_output_port, range(block.num_output_ports()))
        return {port.get_name(): port.Eval(context) for port in ports}

    return outputs_of


@pytest.fixture(scope="session")
def step():
    """A function that takes a block's periodic update in its context."""

    def take_step(block, context):
        state = block.EvalUniquePeriodicDiscreteUpdate(context)
        context.SetDiscreteState(state.value().copy())

    return take_step
