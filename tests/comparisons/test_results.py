from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import jsonschema
import msgspec
import pytest

from comparisons import results
from comparisons.results import Comparison, Provenance, Results


@pytest.fixture
def outcome(compare: Callable[..., Comparison]) -> Results:
    provenance = Provenance(
        date="2026-01-01T00:00:00+00:00",
        command_line=["lightproof"],
        versions={"lightproof": "0"},
        platform="p",
        processors=1,
        seed=0,
        seeds="s",
        budget=1.0,
        alpha=0.001,
        jobs=1,
        seconds=1.0,
    )
    return Results(provenance=provenance, comparisons=[compare("furnace-box", "reference", budget=0.5)])


def test_what_is_written_is_read_and_obeys_the_shipped_schema(outcome: Results, tmp_path: Path) -> None:
    path = results.write(outcome, tmp_path)
    assert results.read(tmp_path) == outcome
    document = json.loads(path.read_bytes())
    schema = json.loads(results.SCHEMA_FILE.read_bytes())
    jsonschema.validate(document, schema, cls=jsonschema.Draft202012Validator)
    document["comparisons"][0]["bounces"][0]["verdict"] = "perhaps"
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document, schema, cls=jsonschema.Draft202012Validator)


def test_a_file_from_before_the_newer_fields_is_read(outcome: Results, tmp_path: Path) -> None:
    path = results.write(outcome, tmp_path)
    document = json.loads(path.read_bytes())
    [comparison] = document["comparisons"]
    for name in ("term_metrics", "single_image"):
        del comparison[name]
    for metrics in comparison["metrics"]:
        for name in ("rmse", "rel_mse", "flip", "delta_e"):
            del metrics[name]
    path.write_text(json.dumps(document))
    [found] = results.read(tmp_path).comparisons
    assert (found.term_metrics, found.single_image) == ([], None)
    assert found.metrics[0].flip is None
    assert found.metrics[0].nrmse == outcome.comparisons[0].metrics[0].nrmse


def test_the_fields_other_programs_read(outcome: Results, tmp_path: Path) -> None:
    [comparison] = json.loads(results.write(outcome, tmp_path).read_bytes())["comparisons"]
    assert {"case", "renderer", "verdict", "truth", "seconds", "spp", "replicates"} <= comparison.keys()
    for bounce in comparison["bounces"]:
        assert {
            "bounce",
            "verdict",
            "truth_mean",
            "mean",
            "bias",
            "interval",
            "detectable_bias",
        } <= bounce.keys()
        assert {"resolution", "channels", "worst_tile", "simultaneous_interval"} <= bounce.keys()
        assert {"place", "bias", "interval"} <= bounce["worst_tile"].keys()


def test_the_shipped_schema_is_that_of_the_code() -> None:
    """If this fails: make schema."""
    assert json.loads(results.SCHEMA_FILE.read_bytes()) == results.schema()


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"{}", "version None, expected '1.0'"),
        (b'{"version": "0.9"}', "version '0.9', expected '1.0'"),
        (b'{"version": "1.0"}', "missing required field `provenance`"),
        (b"[]", "Expected `object`"),
        (b'{"version"', "truncated"),
    ],
)
def test_what_is_no_results_file_is_refused(tmp_path: Path, content: bytes, complaint: str) -> None:
    (tmp_path / results.RESULTS_FILE).write_bytes(content)
    with pytest.raises(results.ResultsError) as caught:
        results.read(tmp_path)
    assert complaint in str(caught.value)


def test_a_folder_without_results_is_refused(tmp_path: Path) -> None:
    with pytest.raises(results.ResultsError, match="lightproof validate"):
        results.read(tmp_path)


def test_what_json_has_no_number_for_is_not_written(outcome: Results, tmp_path: Path) -> None:
    broken = msgspec.structs.replace(outcome.provenance, seconds=float("nan"))
    with pytest.raises(results.ResultsError, match="not finite"):
        results.write(msgspec.structs.replace(outcome, provenance=broken), tmp_path)
