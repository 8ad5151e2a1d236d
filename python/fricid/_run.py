"""The steps of a run, and its folder."""
import dataclasses
import json
import os
import pathlib
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias

from . import _core
from ._errors import UserError
from ._scene import to_toml

StrPath: TypeAlias = str | os.PathLike[str]
SceneLike: TypeAlias = StrPath | Mapping[str, Any]
#: Called with (stage, done, total, seconds, figure) up to ten times a second.
ProgressCallback: TypeAlias = Callable[[str, float, float, float, str], object]


def _read_json(file: pathlib.Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(file.read_text())
    return content


def _is_run(place: pathlib.Path) -> bool:
    return _core.RunFolder(place).manifest.exists()


class Run:
    """A run folder: inputs and results of a run. Files are read at every access."""

    def __init__(self, folder: StrPath) -> None:
        self.folder = pathlib.Path(folder)
        self._files = _core.RunFolder(self.folder)
        if not self._files.manifest.exists():
            raise UserError(
                f"{self.folder}: found no {self._files.manifest.name}; "
                "allowed: the folder of a run"
            )

    def __repr__(self) -> str:
        return f"<fricid.Run {self.folder}>"

    def __fspath__(self) -> str:
        return str(self.folder)

    @property
    def models(self) -> dict[str, _core.Model]:
        """The identified models, by name and seed ("lugre_s1"), of the present data: others are left
        out with a warning."""
        return {file.stem: _core.Model.load(file) for file in self._present(self._files.models)}

    @property
    def logs(self) -> dict[str, _core.Log]:
        """The recordings, by name ("train_0", "validation_0")."""
        return {file.stem: _core.Log.load(file) for file in self._files.recordings}

    @property
    def fits(self) -> dict[str, dict[str, Any]]:
        """The reports of the fits (docs/run_folder.md), by name and seed, as `models`."""
        return {file.stem: _read_json(file) for file in self._present(self._files.fits)}

    def _present(self, results: Iterable[pathlib.Path]) -> list[pathlib.Path]:
        """Those of the present data; of the others a warning."""
        present = []
        for file in results:
            if why := self._files.outdated(file):
                warnings.warn(f"{file}: left out: {why}", stacklevel=3)
            else:
                present.append(file)
        return present

    @property
    def evaluation(self) -> dict[str, Any]:
        """What `fricid evaluate` found (docs/run_folder.md).

        Raises UserError where the run was not evaluated, or its data or fits are others since.
        """
        file = self._files.evaluation
        if not file.exists():
            raise UserError(f"{self.folder}: was not evaluated; fricid.evaluate does it")
        if why := self._files.outdated(file):
            raise UserError(f"{file}: {why}; fricid.evaluate makes it again")
        return _read_json(file)

    @property
    def table(self) -> list[dict[str, Any]]:
        """One row per model: name and errors at each horizon, e.g. for pandas.DataFrame."""
        evaluation = self.evaluation
        rows = []
        for model in evaluation["summary"]:
            row = {key: model[key] for key in ("name", "label", "seeds", "parameters", "friction")}
            for horizon, mse in zip(evaluation["horizons_s"], model["q_mse_geometric_mean"]):
                row[f"q_mse_{horizon:g}s"] = mse
            row["doubts"] = "; ".join(model["doubts"])
            rows.append(row)
        return rows

    @property
    def doubts(self) -> list[str]:
        """Why not to trust the fits or the evaluation, one line each; empty: no reason found."""
        found = [
            f"{recording.stem}: {fault['name']}: {fault['consequence']}; {fault['remedy']}"
            for recording in self._files.recordings
            if (file := _core.RunFolder.diagnosis_beside(recording)).exists()
            for fault in _read_json(file)["findings"]
            if fault.get("misleads", False)
        ]
        found += [f"{file.name}: {why}" for file in self._files.models
                  if (why := self._files.outdated(file))]
        fits = {file.stem: _read_json(file) for file in self._files.fits
                if not self._files.outdated(file)}
        found += [
            f"{name}: {fault['joint'] + ': ' if fault['joint'] else ''}{fault['found']}; "
            f"{fault['remedy']}"
            for name, fit in fits.items()
            for fault in fit["faults"]
        ]
        found += [f"{name}: {fit['message']}" for name, fit in fits.items()
                  if not fit["usable"] and not fit["faults"]]
        if self._files.payload.exists():
            payload = _read_json(self._files.payload)
            found += [f"payload: {doubt}" for doubt in payload["doubts"]]
            if payload["outcome"] != "converged":
                found.append(f"payload: {payload['message']}")
        if self._files.evaluation.exists():
            if why := self._files.outdated(self._files.evaluation):
                return [*dict.fromkeys(found), f"{self._files.evaluation.name}: {why}"]
            evaluation = self.evaluation
            for model in evaluation["summary"]:
                found += [f"{model['name']}: {doubt}" for doubt in model["doubts"]]
            for torque in evaluation["unexplained"]:
                place = ", ".join(filter(None, (torque["recording"], torque["joint"])))
                found.append(f"{place}: {torque.get('difference') or 'its torque is unexplained'}")
            found += [line for line in evaluation["meaningless"] if line]
        return list(dict.fromkeys(found))

    @property
    def trusted(self) -> bool:
        """Whether the results may be trusted: the program would end with 0, not 1."""
        return not self.doubts


def _source(scene: SceneLike | Run, folder: StrPath | None, seed: int | None, fresh: bool,
            jobs: int) -> tuple[_core.Source, pathlib.Path]:
    text: str | None = None
    if isinstance(scene, Mapping):
        text = to_toml(scene)
        if folder is None:
            raise UserError("folder is missing; allowed: the folder of the run")
        path = pathlib.Path(folder)
    else:
        place = pathlib.Path(scene)
        if folder is not None:
            path = pathlib.Path(folder)
        elif _is_run(place):
            path = place
        else:
            raise UserError(f"{place}: folder is missing; allowed: the folder of the run")
    source = pathlib.Path(scene) if text is None else text  # type: ignore[arg-type]
    return _core.Source(source, path, seed, fresh, jobs), path


def simulate(scene: SceneLike, folder: StrPath, *, seed: int | None = None, fresh: bool = False,
             jobs: int = 0, progress: ProgressCallback | None = None) -> Run:
    """Simulates the ground truth of a scene: recordings and truth, no fits.

    scene: file, or dict of what a scene file says (file names start in the current folder).
    folder: of the run; new, empty or that of an earlier run, which goes on.
    seed: of the data; None: the scene's. fresh: repeat all stages. jobs: threads, 0: all cores.
    """
    source, path = _source(scene, folder, seed, fresh, jobs)
    _core.simulate(source, progress)
    return Run(path)


def identify(scene: SceneLike | Run, folder: StrPath | None = None, *, models: Sequence[str] = (),
             seeds: Iterable[int] = (), seed: int | None = None, fresh: bool = False,
             jobs: int = 0, progress: ProgressCallback | None = None) -> Run:
    """Fits models to the training data of a scene or run, which are made where they are missing.

    models, seeds: of the scene, or these. A fit that is not to be trusted is no error: see
    `Run.doubts`.
    """
    source, path = _source(scene, folder, seed, fresh, jobs)
    _core.identify(source, list(models), list(seeds), progress)
    return Run(path)


def evaluate(run: Run | StrPath, *, data: Iterable[StrPath] = (), fresh: bool = False,
             jobs: int = 0, progress: ProgressCallback | None = None) -> Run:
    """Open loop of the models of a run against held-out data.

    data: further recordings (HDF5), which the run never saw.
    """
    source, path = _source(run, run, None, fresh, jobs)
    _core.evaluate(source, [pathlib.Path(file) for file in data], progress)
    return Run(path)


@dataclasses.dataclass(frozen=True)
class Check:
    """Result of a check."""

    whole: bool  #: no damage
    report: dict[str, Any]  #: fricid.check/2
    text: str  #: the same in words

    def __str__(self) -> str:
        return self.text


def check(data: Run | _core.Log | StrPath, *, robot: StrPath | None = None,
          contract: StrPath | None = None, mount: str = "floor",
          mend_inertia: bool = False) -> Check:
    """Faults of data, and with a robot which parameters they identify.

    data: a run, a Log, a data set (HDF5), or a log file with its contract. robot: URDF;
    mount: of its base, floor, ceiling, wall, or roll, pitch and yaw in rad, "0.3,-0.45,0";
    mend_inertia: take the nearest inertia that a body can have where that of a link is none (a
    run has both of its scene).
    """
    urdf = pathlib.Path(robot) if robot is not None else ""
    if isinstance(data, _core.Log):
        found = _core.check_log(data, urdf, mount, mend_inertia)
    elif _is_run(pathlib.Path(data)):
        if robot is not None or mount != "floor" or mend_inertia:
            raise UserError(f"{data}: a run with robot, mount or mend_inertia; allowed: its own robot")
        found = _core.check_run(pathlib.Path(data))
    else:
        columns = pathlib.Path(contract) if contract is not None else ""
        found = _core.check_file(pathlib.Path(data), columns, urdf, mount, mend_inertia)
    return Check(found[0], json.loads(found[1]), found[2])


def save_logs(folder: StrPath, train: Sequence[_core.Log],
              validation: Sequence[_core.Log]) -> dict[str, Any]:
    """Saves logs in a folder for a scene to read, as it does the files of a robot.

    Returns the section "data" of such a scene: {"robot": ..., "data": save_logs(...), "model": ...}.
    """
    place = pathlib.Path(folder).absolute()
    logs = [*train, *validation]
    if not logs:
        raise UserError(f"{folder}: no logs; allowed: one or more to train on")
    names = list(logs[0].joint_names)
    if any(sorted(log.joint_names) != sorted(names) for log in logs):
        raise UserError(f"{folder}: logs of different joints; allowed: those of one robot, in any order")
    section: dict[str, Any] = {"contract": str(place / "contract.toml")}
    for kind, sets in (("train", train), ("validation", validation)):
        files = [place / f"{kind}_{i}.h5" for i in range(len(sets))]
        for log, file in zip(sets, files):
            log.of_joints(names).save(file)
        section[kind] = [str(file) for file in files]
    signals = {"position": "q{}", "torque": "tau{}"}
    if all(log.v is not None for log in logs):
        signals["velocity"] = "v{}"
    if all(log.temperature is not None for log in logs):
        signals["temperature"] = "temperature{}"
    contract: dict[str, Any] = {"joint_names": names, "format": "hdf5"}
    contract |= {signal: {"columns": [columns]} for signal, columns in signals.items()}
    (place / "contract.toml").write_text(to_toml(contract))
    return section


def draw(run: Run | StrPath, *, fresh: bool = False, jobs: int = 0,
         progress: ProgressCallback | None = None) -> str:
    """Makes plots (needs gnuplot) and report.html. Returns why plots are missing, or ""."""
    source, _ = _source(run, run, None, fresh, jobs)
    return _core.draw(source, progress)
