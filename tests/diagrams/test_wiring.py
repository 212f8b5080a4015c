"""Wiring: what is asked for is done or refused, and no input stays open in silence."""

import pytest
from drake_mobman.diagrams import make_diagram
from drake_mobman.diagrams.wiring import connect_by_name, outputs
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource

from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robots.kinematic import Kinematic
from drake_mobman.scenario import Guided, load_scenario, scenario_paths


class Taking(LeafSystem):
    """A decomposer that takes a signal besides."""

    def __init__(self, *names):
        super().__init__()
        self.set_name("taker")
        for name in names:
            self.DeclareVectorInputPort(name, 3)
        for name, size in (
            ("base_command", 2),
            ("base_contribution", 2),
            ("arm_command", 3),
        ):
            self.DeclareVectorOutputPort(
                name,
                size,
                lambda _, output, size=size: output.SetFromVector([0.0] * size),
                prerequisites_of_calc={self.nothing_ticket()},
            )


def test_input_that_finds_no_signal_is_refused_with_the_names_that_there_are():
    builder = DiagramBuilder()
    source = builder.AddSystem(ConstantVectorSource([0.0] * 3))
    taker = builder.AddSystem(Taking("y0", "ee_comand"))
    with pytest.raises(
        ValueError, match=r"'ee_comand'; valid names are y0$"
    ) as refused:
        connect_by_name(builder, outputs([source]), [taker])
    assert str(refused.value).startswith("taker: no block has an output for its input")
    connect_by_name(builder, outputs([source]), [Taking("ee_comand")], ["ee_comand"])


@pytest.mark.parametrize("source", ["script", "external", "operator"])
def test_decomposer_with_an_unknown_input_is_refused(source):
    scenario = load_scenario("kwon_1", [f"source={source}"])
    make_diagram(scenario, decomposer=Taking("ee_command"))
    with pytest.raises(ValueError, match="has an output for its input 'workspce'"):
        make_diagram(scenario, decomposer=Taking("ee_command", "workspce"))


@pytest.mark.parametrize("name", scenario_paths())
@pytest.mark.parametrize("source", ["", "source=operator"])
def test_no_input_of_a_scenarios_blocks_is_open_but_forces(name, source):
    scenario = load_scenario(name, [source] if source else [])
    diagram = make_diagram(scenario)
    context = diagram.CreateDefaultContext()
    given = [diagram.get_input_port(i) for i in range(diagram.num_input_ports())]
    for port in given:
        port.FixValue(context, [0.0] * port.size())
    for system in diagram.GetSystems():
        mine = system.GetMyContextFromRoot(context)
        for i in range(system.num_input_ports()):
            port = system.get_input_port(i)
            assert port.HasValue(mine) or port.get_name() == "spatial_forces"


def test_a_free_arm_is_refused_where_there_are_no_forces():
    with pytest.raises(ParameterError, match=r"^fidelity: '!Kinematic' is not valid"):
        checked(Guided(fidelity=Kinematic()))
