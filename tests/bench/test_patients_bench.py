"""Finding patients among ten thousand; printed, and only its growth is asserted."""

from __future__ import annotations

import sys
import time

import numpy as np
import pytest

from sessions.catalogue import Catalogue, Patient

pytestmark = pytest.mark.bench

GIVEN = ("Zoë", "José", "Ada", "Ελένη", "秀英", "Åsa")
FAMILY = ("Łuczak", "Rossi", "Ibáñez", "Müller", "Παπάς", "王", "O'Neill", "Straße")
TYPED = ("", "luczak", "zoe7 rossi", "14.3.1957", "p-0777", "nobody")


def fill(catalogue: Catalogue, many: int) -> None:
    """Add made-up patients in one transaction each, as the clinic does."""
    draw = np.random.default_rng(3)
    for number in range(many):
        given, family = GIVEN[draw.integers(len(GIVEN))], FAMILY[draw.integers(len(FAMILY))]
        born = f"19{draw.integers(30, 100)}-0{draw.integers(1, 10)}-1{draw.integers(10)}"
        person = Patient(
            given_name=f"{given}{number % 97}",
            family_name=f"{family}{number % 313}",
            birth_date=born,
            side="left",
            impairment="x" * 200,
        )
        catalogue.add_patient(person)


def median_s(catalogue: Catalogue) -> float:
    """Median time of a search, s, over several words and rounds."""
    times_s = []
    for typed in TYPED * 5:
        start_s = time.perf_counter()
        catalogue.find_patients(typed)
        times_s.append(time.perf_counter() - start_s)
    return float(np.median(times_s))


def test_a_search_of_ten_thousand_grows_no_faster_than_the_clinic(tmp_path):
    with Catalogue.open(tmp_path) as catalogue:
        fill(catalogue, 1000)
        few_s = median_s(catalogue)
        fill(catalogue, 9000)
        many_s = median_s(catalogue)
    sys.stdout.write(f"search: {1e3 * few_s:.1f} ms of 1,000 patients, {1e3 * many_s:.1f} ms of 10,000\n")
    assert many_s < 20.0 * few_s
