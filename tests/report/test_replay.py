"""The replay shows bodies where they were, moves in step with the plots, and can be turned."""

from __future__ import annotations

import pytest
from playwright.sync_api import Browser

from tests.report.conftest import Opener
from tests.report.opened import Opened
from tests.report.sample_document import END_S, sample_document


def test_shows_bodies_that_move(report: Opened) -> None:
    report.press("Home")
    at_start = report.replay_picture()
    assert at_start.colors() > 10 and at_start.count_visible_pixels() > 5000
    report.page.get_by_label("Time after release").fill("1.4")
    assert report.replay_picture().unlike(at_start) > 3000
    assert report.time_s == pytest.approx(1.4)
    assert report.page.locator(".what").inner_text() == "2: joint 2, +70 deg"


def test_opens_where_the_robot_came_to_and_plays_from_the_start(open_document: Opener) -> None:
    report = open_document(sample_document())
    assert report.time_s == pytest.approx(END_S)
    assert report.page.locator(".caption").inner_text().split("\n")[-2:] == ["·", "end of the evaluation"]
    report.press(" ")
    report.page.wait_for_function(
        "() => parseFloat(document.querySelector('.when').textContent.replace('−', '-')) < 2"
    )
    report.press(" ")
    assert report.time_s < END_S - 0.5


def test_space_plays_and_pauses(report: Opened) -> None:
    report.press("Home", " ")
    report.page.wait_for_function("() => parseFloat(document.querySelector('.when').textContent) > 0.2")
    assert report.page.get_by_role("button", name="Pause").is_visible()
    report.press(" ")
    assert report.page.get_by_role("button", name="Play").is_visible()
    stopped = report.time_s
    report.page.wait_for_function(
        "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
    )
    assert report.time_s == stopped
    assert report.hairlines()["rates"] > 0


def test_stops_at_the_end_and_starts_over(report: Opened) -> None:
    speed = report.page.get_by_label("Speed")
    usual = speed.input_value()
    speed.select_option("1")
    # One step before the end: it plays on and stops by itself.
    report.press("End", "ArrowLeft", " ")
    report.page.get_by_role("button", name="Play").wait_for()
    assert report.time_s == pytest.approx(2.8)
    report.press(" ")
    report.page.wait_for_function("() => !document.querySelector('.when').textContent.startsWith('2.8')")
    report.press(" ")
    speed.select_option(usual)


def test_keys_turn_it_and_zero_turns_it_back(report: Opened) -> None:
    before, time_s = report.replay_picture(), report.time_s
    report.page.locator("canvas.bodies").focus()
    for key in ("ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "+", "-"):
        report.press(key)
        assert report.replay_picture().unlike(before) > 1000, key
        report.press("0")
        assert report.replay_picture().unlike(before) == 0, key
    assert report.time_s == time_s


def test_the_mouse_turns_it(report: Opened) -> None:
    bodies = report.page.locator("canvas.bodies")
    bodies.scroll_into_view_if_needed()  # with wide fonts it lies below the window's edge, where no mouse comes
    before = report.replay_picture()
    box = bodies.bounding_box()
    assert box is not None
    report.page.mouse.move(box["x"] + 200, box["y"] + 200)
    report.page.mouse.down()
    report.page.mouse.move(box["x"] + 260, box["y"] + 210, steps=3)
    report.page.mouse.up()
    turned = report.replay_picture()
    assert turned.unlike(before) > 1000
    report.page.mouse.move(box["x"] + 100, box["y"] + 100)
    assert report.replay_picture().unlike(turned) == 0, "it follows the mouse only while a button is down"
    bodies.focus()
    report.press("0")


def test_the_model_stands_over_beside_or_nowhere(report: Opened) -> None:
    report.page.get_by_label("Time after release").fill("1.4")
    assert report.page.locator(".sides span").all_inner_texts() == ["measured", "nominal model"]
    report.page.get_by_label("Model", exact=True).select_option("over")
    assert report.page.locator(".sides").is_hidden()
    over = report.replay_picture()
    report.page.get_by_label("Model", exact=True).select_option("hidden")
    hidden = report.replay_picture()
    report.page.get_by_label("Model", exact=True).select_option("beside")
    beside = report.replay_picture()
    assert hidden.unlike(over) > 200
    assert beside.count_visible_pixels() > hidden.count_visible_pixels() + 1000
    assert beside.unlike(over) > 1000


def test_59_70_stands_beside_a_drop_whose_joints_moved_together(
    open_document: Opener, report: Opened
) -> None:
    model = report.page.get_by_label("Model", exact=True)
    assert model.locator("option").all_inner_texts() == ["beside", "overlaid", "hidden"]
    document = sample_document()
    replay = document["drops"][0]["replay"]
    # Bodies that never move can be told from the model's.
    replay["reference"] = [replay["measured"][0]] * len(replay["t_s"])
    together = open_document(document)
    together.page.get_by_label("Time after release").fill("1.4")
    beside_model = together.replay_picture()
    together.page.get_by_label("Model", exact=True).select_option("59/70 beside")
    assert together.page.locator(".sides span").all_inner_texts() == ["measured", "59/70 simulated"]
    assert together.replay_picture().unlike(beside_model) > 1000


def test_missing_poses_hide_their_bodies_and_a_missing_model_its_ghost(open_document: Opener) -> None:
    document = sample_document()
    replay = document["drops"][0]["replay"]
    replay["model"] = None
    full_report = open_document(document)
    assert not full_report.page.get_by_label("Model", exact=True).is_visible()
    assert full_report.page.locator(".bodies-key li").all_inner_texts() == [
        "body 1",
        "body 2",
        "body 3",
        "body 4",
    ]
    for poses in replay["measured"][:50]:
        poses[:] = [[None] * 7 for _ in poses]
    partly = open_document(document)
    for report in (full_report, partly):
        report.press("Home")
    assert (
        partly.replay_picture().count_visible_pixels()
        < full_report.replay_picture().count_visible_pixels() - 5000
    )


def test_without_webgl_it_says_so_and_draws_flat(
    open_document: Opener, browser_without_webgl: Browser
) -> None:
    report = open_document(sample_document(), into=browser_without_webgl)
    assert "no WebGL" in report.page.locator(".replay .note").inner_text()
    report.press("Home")
    at_start = report.replay_picture()
    assert at_start.count_visible_pixels() > 5000
    report.page.get_by_label("Time after release").fill("1.4")
    assert report.replay_picture().unlike(at_start) > 3000


def test_without_poses_it_says_so(open_document: Opener) -> None:
    document = sample_document()
    document["drops"][0].update(
        replay=None, no_replay="Replay withheld: gyros of bodies 3 and 4 (check failed)"
    )
    report = open_document(document)
    assert report.page.locator(".replay .note").inner_text() == document["drops"][0]["no_replay"]
    report.press("ArrowRight")
    assert report.hairlines()["rates"] > 0
