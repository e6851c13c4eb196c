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
from reflexarc_runtime.files import write_atomically

_SECRET_MODE = 0o600


def make_key(path: Path) -> Path:
    """Make a key, and the public one beside it, `.pub`; return that.

    Raises:
        UsageError: there is a file of one of these names.
    """
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
        OSError: a file cannot be read or written.
    """
    try:
        key = serialization.load_pem_private_key(key_path.read_bytes(), None)
    except (ValueError, TypeError) as error:
        raise UsageError(f"--key: {key_path}: expected a key: {first_line(error)}") from None
    if not isinstance(key, Ed25519PrivateKey):
        raise UsageError(f"--key: {key_path}: expected a secret key of Ed25519")
    signature = path.with_name(f"{path.name}.sig")
    write_atomically(signature, key.sign(path.read_bytes()))
    return signature
