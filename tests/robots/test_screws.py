"""Many samples at once give what the plant gives one by one."""

import numpy as np
import pytest

from drake_mobman.frames import frame
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.end_effector import manipulabilities
from drake_mobman.robots.franka_tiago import FrankaTiago
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.screws import moved
from drake_mobman.robots.spatial import Spatial
from drake_mobman.scenario import load_scenario

ROBOTS = {
    "planar": Planar,
    "spatial": Spatial,
    "franka": FrankaTiago,
    # A lift, and joints that point down.
    **{
        name: lambda name=name: (
            load_scenario("kwon_franka", [f"robot=!File {{path: {name}}}"]).robot
        )
        for name in ("tiago", "gen3", "so101")
    },
}


@pytest.fixture(scope="module", params=ROBOTS)
def model(request):
    return RobotModel(ROBOTS[request.param]())


@pytest.mark.parametrize("name", ["tool", "tee", "base"])
def test_frames_are_where_the_plant_has_them_and_move_as_fast(model, name):
    random, plant = np.random.default_rng(7), model.plant
    n = plant.num_positions()
    q, v = random.uniform(-3, 3, (50, n)), random.uniform(-2, 2, (50, n))
    F = frame(plant, name)
    found = moved(plant, F, q.T)
    context = plant.CreateDefaultContext()
    for k in range(len(q)):
        plant.SetPositions(context, q[k])
        plant.SetVelocities(context, v[k])
        X = F.CalcPoseInWorld(context)
        V = F.CalcSpatialVelocityInWorld(context).translational()
        assert np.allclose(found.p_WF[:, k], X.translation(), rtol=0, atol=1e-12)
        assert np.allclose(
            found.R_WF[:, :, k], X.rotation().matrix(), rtol=0, atol=1e-12
        )
        assert np.allclose(found.velocity(v.T)[:, k], V, rtol=0, atol=1e-12)


def test_manipulability_is_the_plants(model):
    q = np.random.default_rng(8).uniform(-3, 3, (50, model.plant.num_positions()))
    found = manipulabilities(model, q)
    for sample, value in zip(q, found, strict=True):
        model.set_state(sample, np.zeros_like(sample))
        # A root: what is rounded below it counts more near zero.
        assert value**2 == pytest.approx(model.manipulability() ** 2, abs=1e-12)
