"""Services that are built when they are first used."""

from __future__ import annotations

import threading
from types import SimpleNamespace

import pytest

from rehab_app.services.later import later


def test_nothing_is_built_before_it_is_used_and_then_once():
    built = []

    def build():
        built.append(SimpleNamespace(answer=42))
        return built[-1]

    service = later(build)
    assert built == []
    assert (service.answer, service.answer) == (42, 42)
    assert len(built) == 1


def test_what_is_set_is_set_on_the_service_itself():
    real = SimpleNamespace(answer=1)
    service = later(lambda: real)
    service.answer = 2
    assert real.answer == 2
    del service.answer
    with pytest.raises(AttributeError):
        _ = service.answer


def test_many_threads_get_the_same_one():
    built, seen = [], []
    gate = threading.Barrier(8)

    def build():
        built.append(object())
        return SimpleNamespace(one=built[-1])

    service = later(build)

    def use():
        gate.wait()
        seen.append(service.one)

    threads = [threading.Thread(target=use) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(built) == 1
    assert seen == [built[0]] * 8


def test_a_service_that_cannot_be_built_says_so_each_time():
    def build():
        raise ValueError("no")

    service = later(build)
    for _ in range(2):
        with pytest.raises(ValueError, match="no"):
            _ = service.answer
