"""Messages between app and motion process as MessagePack: typed, sized, never pickled."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np

from robot_iface.errors import Refused
from robot_iface.link.messages import MESSAGES

MAX_MESSAGE_BYTES = 64 * 1024 * 1024
_MAX_DIMENSIONS = 2
_DTYPES: dict[str, Any] = {"f8": np.dtype("<f8"), "i8": np.dtype("<i8"), "u1": np.dtype("u1")}


class _Envelope(msgspec.Struct, array_like=True, frozen=True, forbid_unknown_fields=True):
    kind: str
    body: msgspec.Raw


class _Array(msgspec.Struct, array_like=True, frozen=True, forbid_unknown_fields=True):
    dtype: str
    shape: tuple[int, ...]
    content: bytes


def encode(message: Any) -> bytes:
    """Bytes of one message.

    Raises:
        TypeError: The message is not one of MESSAGES.
        Refused: The message is larger than MAX_MESSAGE_BYTES.
    """
    kind = type(message).__name__
    if MESSAGES.get(kind) is not type(message):
        raise TypeError(f"{kind} is not a message of the link")
    content = _ENCODER.encode(_Envelope(kind, msgspec.Raw(_ENCODER.encode(message))))
    if len(content) > MAX_MESSAGE_BYTES:
        raise Refused(kind, f"{len(content)} bytes", f"at most {MAX_MESSAGE_BYTES} bytes", "shorten the path")
    return content


def decode(content: bytes) -> Any:
    """The message in ``content``, one of MESSAGES.

    Raises:
        Refused: The bytes are no message of the link, or one whose values its type refuses.
    """
    try:
        envelope = _ENVELOPE.decode(content)
        decoder = _DECODERS.get(envelope.kind)
        if decoder is None:
            raise msgspec.ValidationError(f"no message is called {envelope.kind[:40]!r}")
        return decoder.decode(envelope.body)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise Refused(
            "link message",
            f"unreadable ({error})",
            "a message of this software version",
            "restart the app so that both processes run the same version",
        ) from error


def _plain(value: Any) -> Any:
    """An array as a small struct; anything else that MessagePack lacks is a mistake."""
    if isinstance(value, np.ndarray):
        array: Any = np.ascontiguousarray(value)
        name = f"{array.dtype.kind}{array.dtype.itemsize}"
        return _Array(name, array.shape, array.astype(_DTYPES[name], copy=False).tobytes())
    raise NotImplementedError(f"{type(value).__name__} cannot be sent")


def _typed(kind: Any, value: Any) -> Any:
    """An array again, if its bytes fit its shape; read-only, as it is a view of the message."""
    if getattr(kind, "__origin__", kind) is not np.ndarray:
        raise NotImplementedError(f"{kind} cannot be received")
    array = msgspec.convert(value, _Array)
    dtype = _DTYPES.get(array.dtype)
    if dtype is None or len(array.shape) > _MAX_DIMENSIONS or any(size < 0 for size in array.shape):
        raise ValueError(f"array of type {array.dtype[:8]!r} and shape {array.shape[:4]}")
    if int(np.prod(array.shape, dtype=np.int64)) * dtype.itemsize != len(array.content):
        raise ValueError(f"array of shape {array.shape} in {len(array.content)} bytes")
    return np.frombuffer(array.content, dtype).reshape(array.shape)


_ENCODER = msgspec.msgpack.Encoder(enc_hook=_plain)
_ENVELOPE = msgspec.msgpack.Decoder(_Envelope)
_DECODERS: dict[str, Any] = {
    name: msgspec.msgpack.Decoder(kind, dec_hook=_typed) for name, kind in MESSAGES.items()
}
