"""One page on a study: pictures, figures, and what failed."""
import csv
import dataclasses
import io
import os

from patinate import InputError, _native

from .folder import made_path

SHOWN = (".png", ".jpg", ".jpeg", ".tif", ".exr")


@dataclasses.dataclass
class CellReport:
    """All that is told of a cell."""
    status: str = "done"
    message: str = ""  # Of what failed.
    figures: dict = dataclasses.field(default_factory=dict)  # "STEP: NAME" -> value.
    pictures: list = dataclasses.field(default_factory=list)  # (data URI, caption)


def _numbers(pairs):
    return {name: float(v) for name, v in pairs if isinstance(v, (int, float)) and not isinstance(v, bool)}


def _of_simulation(json):
    figures = {}
    for material, row in json["ledger"].items():
        figures |= _numbers((f"{material} {c}", row.get(c)) for c in ("emitted", "on_surfaces", "left"))
    for thing, facts in json["outcome"]["objects"].items():
        figures |= _numbers((f"{thing} {name}", value) for name, value in facts.items())
    return figures


def _of_fit(json):
    figures = {}
    for name, member in (("objective", "objective"), ("held out", "held_out")):
        if json[member] is not None:
            figures |= {f"{name} {when}": json[member][when] for when in ("before", "after")}
    for p in json["parameters"]:
        low, high = p["interval"]
        figures |= {p["pointer"]: p["best"], f"{p['pointer']} at least": low, f"{p['pointer']} at most": high}
    return _numbers(figures.items())


def figures_of(made):
    """What a step's output says of itself: name -> value."""
    def said(name):
        path = os.path.join(made, name)
        return _native._load_json(path) if os.path.isfile(path) else None

    def listed(figures):
        return _numbers((f["name"], f["value"]) for f in figures)

    figures = {}
    if transfer := said("transfer.json"):
        figures |= _numbers(transfer["energy"].items())
    if simulation := said("simulation.json"):
        figures |= _of_simulation(simulation)
    if evaluation := said("evaluation.json"):
        for one in evaluation["maps"]:
            figures |= listed(one["figures"])
    if report := said("report.json"):
        figures |= _of_fit(report) if report.get("format") == "patinate.fit" else listed(report.get("figures", []))
    return figures


def _cell_report(study, part, cell):
    report = CellReport()

    def fail(step, message):
        report.status, report.message = "failed", f"{step.name}: {message}"

    for step in part.steps:
        if not study.is_done(step, cell):
            message = study.failure(step, cell)
            if message is not None and report.status != "failed":
                fail(step, message)
            elif message is None and report.status == "done":
                report.status = "not run"
            continue
        made = study.inside(made_path(step, cell))
        try:
            report.figures |= {f"{step.name}: {name}": value for name, value in figures_of(made).items()}
            if made.lower().endswith(SHOWN) and os.path.isfile(made):
                picture = _native._thumbnail(made, study.inside(f".{cell.name}.thumbnail.png"))
                report.pictures.append((picture, f"{cell.name}: {step.name}"))
        except InputError as error:
            fail(step, str(error))
        except (KeyError, TypeError, ValueError, AttributeError):
            fail(step, f"{made} is damaged")
    return report


def _table(part, reports, number_text):
    """A header, and a row a cell; columns in the order in which they first come."""
    factors = list(dict.fromkeys(name for cell in part.cells for name in cell.factors))
    figures = list(dict.fromkeys(name for report in reports for name in report.figures))
    rows = [[cell.name, *(cell.factors.get(name, "") for name in factors), report.status, report.message,
             *(number_text(report.figures[name]) if name in report.figures else "" for name in figures)]
            for cell, report in zip(part.cells, reports)]
    return ["cell", *factors, "status", "message", *figures], rows


def _blocks(part, reports):
    """The part's piece of the page."""
    yield "heading", part.name
    pictures = [picture for report in reports for picture in report.pictures]
    if pictures:
        yield "pictures", pictures
    yield "table", _table(part, reports, _native._figure_text)
    yield "link", (f"{part.name}.csv", "The table as CSV")
    yield "heading", f"{part.name}: the commands"
    yield "paragraph", "In the study's folder, each makes one of the results above again."
    yield "code", "\n".join(f"# {cell.name}\n" + "".join(f"patinate {command}\n" for command in cell.commands)
                            for cell in part.cells)


def _cell_json(part, cell, report):
    return {"part": part.name, "cell": cell.name, "factors": cell.factors, "status": report.status,
            "message": report.message, "figures": report.figures,
            "made": {step.name: made_path(step, cell) for step in part.steps},
            "commands": {step.name: f"patinate {command}" for step, command in zip(part.steps, cell.commands)}}


def write_study_report(study, report):
    """Writes `report.html`, `report.json` and for each part `PART.csv` into a study's folder. Equal results give equal
    bytes, whoever ran the steps. `report` takes fractions. Gives the numbers of cells done, failed and not run."""
    cells, blocks = [], []
    counts = dict.fromkeys(("done", "failed", "not run"), 0)
    num_cells = len(study.cells())
    for part in study.parts:
        reports = []
        for cell in part.cells:
            reports.append(_cell_report(study, part, cell))
            cells.append(_cell_json(part, cell, reports[-1]))
            counts[reports[-1].status] += 1
            report(len(cells) / (num_cells + 1))
        blocks += _blocks(part, reports)
        text = io.StringIO()
        header, rows = _table(part, reports, _native._number_text)
        csv.writer(text, lineterminator="\n").writerows([header, *rows])
        _native._write(study.inside(part.name + ".csv"), text.getvalue())
    told = f"{num_cells} cells: " + ", ".join(f"{number} {status}" for status, number in counts.items()) + "."
    _native._write(study.inside("report.html"), _native._page(study.name, [("paragraph", told), *blocks]))
    _native._save_json(study.inside("report.json"),
                       {"format": "patinate.study_report", "version": 1, "name": study.name, "cells": cells})
    report(1.0)
    return counts
