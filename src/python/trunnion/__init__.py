"""Rotary-axis errors of five-axis machines: identify, evaluate, close, correct, tables, predict.

The commands of the program as functions on values: files are read by Machine, Observations, Model, Piece and Job, arrays
go in and come out as numpy's, and nothing is written unless asked for. Names and signs are those of the program's files:
ISO 230 symbols (EXA ... ECC), lengths of positions in mm and of errors in um, commanded angles in deg and errors in urad.

    import trunnion
    machine = trunnion.Machine("machine.toml")
    found = trunnion.identify(machine, trunnion.Observations("replica.csv", machine))
    found.model.error("EAA")                            # urad, one per station of A
    trunnion.evaluate(machine, found.model, -90, [0, 60, 120], [100, 0, 50]).deviation_um
"""
from ._trunnion import (
    Closure,
    Correction,
    Error,
    Evaluation,
    Identification,
    InputError,
    Job,
    Machine,
    Model,
    ModelError,
    Observations,
    Piece,
    Prediction,
    RangeError,
    RefusalError,
    Tables,
    UsageError,
    __version__,
    close,
    correct,
    evaluate,
    identify,
    predict,
    tables,
)

__all__ = [
    "Closure",
    "Correction",
    "Error",
    "Evaluation",
    "Identification",
    "InputError",
    "Job",
    "Machine",
    "Model",
    "ModelError",
    "Observations",
    "Piece",
    "Prediction",
    "RangeError",
    "RefusalError",
    "Tables",
    "UsageError",
    "__version__",
    "close",
    "correct",
    "evaluate",
    "identify",
    "predict",
    "tables",
]
