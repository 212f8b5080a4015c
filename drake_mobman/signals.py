"""The signals that blocks speak: one name, one order and one unit for each."""

EE_COMMAND = "ee_command"
"""3: `v_c` [m/s] along the reach S->E, `omega_c` [rad/s] turning it, `v_z` [m/s] up."""

EE_CYLINDRICAL = "ee_cylindrical"
"""3: `l` [m], `psi` [rad], `z` [m], cylindrical coordinates of p_SE in B's axes.

psi goes on past half a turn, without a jump where the arm points backwards.
"""

P_BT = "p_BT"
"""3: position of the translational end effector T in B [m]."""

BASE_COMMAND = "base_command"
"""2: `v_b` [m/s] forward, `omega_b` [rad/s]: the command of a controller."""

BASE_CONTRIBUTION = "base_contribution"
"""2: `v_bm` [m/s], `omega_b` [rad/s]: the part of `ee_command` left to the base."""

BASE_COMMAND_SMOOTHED = "base_command_smoothed"
"""2: `base_command` after smoothing and limits: what the base gets."""

BASE_ESTIMATE = "base_estimate"
"""3: v, v_y [m/s], omega [rad/s] of B over the period to come, as far as is known."""

BASE_ASTRAY = "base_astray"
"""1: 1 while the base has not moved as it was sent for too long, else 0."""

ARM_COMMAND = "arm_command"
"""3: `v_m` [m/s], `omega_m` [rad/s], `v_z` [m/s]: the arm's part of the command.

These are the rates of `ee_cylindrical` that the arm is to make.
"""

ARM_VELOCITY_COMMAND = "arm_velocity_command"
"""n: commanded joint rates [rad/s]."""

ARM_POSITION = "arm_position"
"""n: joint angles [rad]."""

ARM_VELOCITY = "arm_velocity"
"""n: joint rates [rad/s]."""

BASE_POSE = "base_pose"
"""3: `x_b`, `y_b` [m], `theta_b` [rad] in W."""

BASE_VELOCITY = "base_velocity"
"""3: true velocity of B in W, in B's axes: forward, sideways [m/s], yaw [rad/s]."""

BASE_ODOMETRY = "base_odometry"
"""2: v [m/s], omega [rad/s] of B by the encoders of its wheels."""

BASE_GYRO = "base_gyro"
"""1: omega [rad/s] of B by a gyroscope."""

BASE_MEASURED = "base_measured"
"""3: v, v_y [m/s], omega [rad/s] of B as a tracker outside measures them."""

FLOOR_FORCE = "floor_force"
"""3: the floor's force on wheels and casters: where it acts, x, y in B [m]; up [N].

The mean of the period before, zero at the start. It acts at the zero-moment point:
where that is at the edge of what the robot stands on, the robot begins to tip over.
"""

GUARD_STATUS = "guard_status"
"""1: why the guard stops the command, a `GuardStatus`."""

DECOMPOSER_STATUS = "decomposer_status"
"""1: what slows the end effector down, a sum of `DecomposerStatus` flags."""

ARM_STATUS = "arm_status"
"""1: what bounds the arm's rates, a sum of `ArmStatus` flags."""

FIELD_ZONE = "field_zone"
"""1: where the end effector is in the velocity field, a sum of `Zone` flags."""

TOOL_POSITION = "tool_position"
"""3: p_WE [m]."""

TOOL_VELOCITY = "tool_velocity"
"""3: v_WE [m/s] in W."""

HAND_POSITION = "hand_position"
"""3: p_WH [m], the position of the guiding hand H."""

HAND_FORCE = "hand_force"
"""3: force of the guiding hand in W [N], on the tool or on the point that is dragged.

Zero while the hand has let go.
"""

SPATIAL_FORCES = "spatial_forces"
"""External forces on bodies: a list of `ExternallyAppliedSpatialForce`."""

ROBOT_STATE = "robot_state"
"""Positions, then velocities, as the simulated `MultibodyPlant` has them."""

OPERATOR_INPUT = "operator_input"
"""14: the operator's input, as it reached the robot; any number may be invalid.

`v_c` [m/s], `omega_c` [rad/s], `v_z` [m/s] as in `ee_command`; `dead_man`, 1 while
held; `age` [s] since the operator sent it, infinite while there is none; `stop`, 1
when anyone requests a stop; `choice`, the index of the controller that is to drive; and
the components of `drag`.
"""

DRAG = "drag"
"""7: a point Q of a body B that is dragged, and its target.

Index of B in the plant, 0 while nothing is dragged; p_BQ (3) [m]; and the target of Q
(3) [m], from the base's centre on the floor, in W's axes.
"""

GATE_STATUS = "gate_status"
"""1: why the gate holds the robot still, a `GateStatus`."""

GATE_ARMING = "gate_arming"
"""1: which step of arming the gate is in, an `Arming`."""

HANDOVER = "handover"
"""3: indices of the last controller and of the one now, and the latter's weight."""
