"""Workshop: as many new objects as it has room for, each with a folder that goes with it."""

from pathlib import Path

from tests.support.loops import run
from voa_console.new_object.draft import Draft
from voa_console.new_object.job import Job
from voa_console.new_object.workshop import MOST, Workshop

NOBODY = "http://127.0.0.1:9"


def test_the_object_that_waits_for_the_longest_time_makes_room_but_none_that_is_being_made() -> None:
    async def whole() -> None:
        workshop = Workshop(NOBODY)
        benches = [await workshop.new() for _ in range(MOST)]
        for age, bench in enumerate(benches):
            bench.draft, bench.used_at = Draft(mesh=f"{age}.stl"), float(age)
        benches[0].job = Job(Draft(mesh="0.stl"), "made", 0.0)
        assert workshop.making() is benches[0]
        newest = await workshop.new()
        assert workshop.bench(benches[0].id) is benches[0]
        assert workshop.bench(benches[1].id) is None
        assert not benches[1].folder.exists()
        assert workshop.benches()[0].name == str(MOST - 1)
        assert newest.name == "new object"
        await workshop.close()
        assert not any(bench.folder.exists() for bench in [newest, *benches])

    run(whole())


def test_the_objects_of_a_key_are_seen_with_that_key_alone_and_go_with_it() -> None:
    async def whole() -> None:
        workshop = Workshop(NOBODY)
        own, hers, his = [await workshop.new(key) for key in (None, "hers", "his")]
        for bench in (own, hers, his):
            bench.draft = Draft(mesh="part.stl")
        assert [workshop.benches(key) for key in (None, "hers", "his", "other")] == [[own], [hers], [his], []]
        assert workshop.bench(hers.id, "hers") is hers
        assert workshop.bench(hers.id, "his") is None
        assert workshop.bench(hers.id) is None
        assert "hers" not in repr(hers)
        await workshop.forget("hers")
        await workshop.forget(None)
        assert [workshop.benches(key) for key in (None, "hers", "his")] == [[own], [], [his]]
        assert not hers.folder.exists()
        await workshop.close()

    run(whole())


def test_objects_of_a_key_make_room_for_another_one_of_it_and_else_those_of_the_key_that_has_most() -> None:
    async def whole() -> None:
        workshop = Workshop(NOBODY)
        hers = await workshop.new("hers")
        his = [await workshop.new("his") for _ in range(MOST - 1)]
        for age, bench in enumerate([hers, *his]):
            bench.used_at = float(age)
        await workshop.new("his")
        assert workshop.bench(hers.id, "hers") is hers, "it waits for the longest time, but is of another key"
        assert workshop.bench(his[0].id, "his") is None
        third = await workshop.new("third")
        assert workshop.bench(hers.id, "hers") is hers, "she has only this one"
        assert workshop.bench(his[1].id, "his") is None
        assert workshop.bench(third.id, "third") is third
        await workshop.close()

    run(whole())


def test_a_folder_that_a_person_named_stays(tmp_path: Path) -> None:
    async def whole() -> None:
        workshop = Workshop(NOBODY)
        bench = await workshop.new()
        bench.target = str(tmp_path)
        await workshop.remove(bench)

    run(whole())
    assert tmp_path.is_dir()
