"""The table of metrics: in groups, with units, and no row that says nothing."""

from drake_mobman.analysis.table import Group, Row, flat_table, shown, table_of

GOOD = {
    "ee_error_rms": 0.1,
    "workspace_excess_max": {"l": 0.2, "psi": 0.0},
    "base_speed_max": 0.3,
    "base_jerk_rms": None,
    "joint_speed_max": 1.5,
    "step_time_us": None,
    "died": None,
    "versions": {"drake": "1.2.3"},
}
DEAD = {"died": "died at t = 0 s: no reason", "versions": {"drake": "1.2.3"}}


def test_rows_are_grouped_and_have_units():
    assert table_of({"run": GOOD}) == [
        Group(
            "end effector",
            [
                Row("ee_error_rms", "m/s", {"run": 0.1}),
                Row("workspace_excess_max.l", "m", {"run": 0.2}),
                Row("workspace_excess_max.psi", "rad", {"run": 0.0}),
            ],
        ),
        Group("base", [Row("base_speed_max", "m/s", {"run": 0.3})]),
        Group("arm", [Row("joint_speed_max", "rad/s", {"run": 1.5})]),
    ]


def test_a_row_has_a_value_in_some_column_and_died_only_where_one_did():
    table = table_of({"good": GOOD, "dead": DEAD})
    (run,) = [group for group in table if group.title == "run"]
    assert run.rows == [Row("died", "", {"good": None, "dead": DEAD["died"]})]
    for group in table:
        for row in group.rows:
            assert list(row.values) == ["good", "dead"]
            assert any(value is not None for value in row.values.values())
    assert "run" not in {group.title for group in table_of({"good": GOOD})}


def test_what_no_metric_knows_is_shown_all_the_same():
    assert table_of({"old": {"renamed_since": 2.0}}) == [
        Group("other", [Row("renamed_since", "", {"old": 2.0})])
    ]


def test_nothing_makes_an_empty_table():
    assert table_of({}) == table_of({"run": {}}) == []


def test_flat_table_keeps_died_for_files():
    table = flat_table({"good": GOOD})
    assert table["died"] == {"good": None}
    assert "step_time_us" not in table
    assert not [name for name in table if name.startswith("versions")]


def test_values_are_shown_to_four_digits():
    assert [shown(x) for x in (None, 0.123456, 3, "why")] == ["-", "0.1235", "3", "why"]
