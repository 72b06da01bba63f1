"""How a record type declares its columns: shape, scalar kind and unit, beside the field itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

Float64: TypeAlias = NDArray[np.float64]
Int64: TypeAlias = NDArray[np.int64]
UInt8: TypeAlias = NDArray[np.uint8]
UInt16: TypeAlias = NDArray[np.uint16]
Scalar = Literal["float64", "float32", "int64", "uint8", "uint16", "string"]

ROWS = -1
"""A dimension that varies from record to record (markers in a frame, ticks in a block)."""


@dataclass(frozen=True, slots=True)
class Column:
    """What a field holds.

    Attributes:
        scalar: Kind of one element as it lies in the file.
        shape: Shape of one record's value; () is a scalar, ``ROWS`` a dimension that varies.
        unit: SI unit, or "1" for what has none.
        meaning: One phrase for a stranger who opens the file.
    """

    scalar: Scalar
    shape: tuple[int, ...]
    unit: str
    meaning: str


def column(scalar: Scalar, shape: tuple[int, ...], unit: str, meaning: str) -> Any:
    """Declare one dataclass field together with its column."""
    return field(metadata={"column": Column(scalar, shape, unit, meaning)})


def columns_of(record_type: type[Any]) -> Mapping[str, Column]:
    """The columns of a record type by field name, in declaration order (the protobuf field numbers)."""
    return {item.name: item.metadata["column"] for item in fields(record_type)}
