"""Keys that sign policies: Ed25519 (RFC 8032), as PEM, so that OpenSSL reads and makes them too.

openssl genpkey -algorithm ed25519 -out policies.key
openssl pkey -in policies.key -pubout -out policies.pub
openssl pkeyutl -sign -rawin -inkey policies.key -in policy.onnx -out policy.onnx.sig
"""

import os
from pathlib import Path

from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from reflexarc_runtime.errors import UsageError, first_line
from reflexarc_runtime.files import read_at_most, write_atomically
from reflexarc_runtime.policy.acceptance import signature_path
from reflexarc_runtime.policy.model_file import read_model

_SECRET_MODE = 0o600
_MOST_KEY_BYTES = 1 << 16


def make_key(path: Path) -> Path:
    """Make a key, and the public one beside it, `.pub`; return that.

    Raises:
        UsageError: there is a file of one of these names, or it is none of a file.
    """
    if not path.name:
        raise UsageError(f"{path}: expected the name of a file, got a folder")
    public = path.with_suffix(".pub")
    for taken in (path, public):
        if taken.exists():
            raise UsageError(f"{taken}: expected a new name, found a file: nothing is overwritten")
    if public == path:
        raise UsageError(f"{path}: expected another ending: .pub is for the public key")
    key = Ed25519PrivateKey.generate()
    secret = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, _SECRET_MODE)
    with os.fdopen(handle, "wb") as file:
        file.write(secret)
    told = key.public_key().public_bytes(
        serialization.Encoding.PEM, serialization.PublicFormat.SubjectPublicKeyInfo
    )
    write_atomically(public, told)
    return public


def sign_file(path: Path, key_path: Path) -> Path:
    """Write the signature of all bytes of a file beside it, `<name>.sig`; return that.

    Raises:
        UsageError: the key is none of Ed25519.
        PolicyError: the file cannot be read, or is larger than a policy may be.
        OSError: the key cannot be read, or the signature not written.
    """
    try:
        key = serialization.load_pem_private_key(read_at_most(key_path, _MOST_KEY_BYTES), None)
    except (ValueError, TypeError) as error:
        raise UsageError(f"--key: {key_path}: expected a key: {first_line(error)}") from None
    if not isinstance(key, Ed25519PrivateKey):
        raise UsageError(f"--key: {key_path}: expected a secret key of Ed25519")
    signature = signature_path(path)
    write_atomically(signature, key.sign(read_model(path)))
    return signature
