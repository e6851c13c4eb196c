"""A certificate authority for one robot, and what it signs: X.509, RFC 5280, keys on P-256.

A certificate names a role and a robot as its common name, by which the rights go. Only that of the
door has the purpose of a server, and names of hosts: no other role can pass for the door.
"""

import ipaddress
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

CLOCKS_APART = timedelta(hours=1)
"""A certificate is valid a little before it is made: the clocks of two machines differ."""

Name = x509.DNSName | x509.IPAddress


@dataclass(frozen=True)
class Identity:
    """A certificate and its key, as PEM."""

    certificate: bytes
    key: bytes


@dataclass(frozen=True)
class Validity:
    """From when to when a certificate holds."""

    start: datetime
    end: datetime

    @classmethod
    def of_days(cls, days: float) -> "Validity":
        """From now on."""
        now = datetime.now(UTC)
        return cls(now - CLOCKS_APART, now + timedelta(days=days))


class Authority:
    """Signs the certificates of one robot's bus.

    Args:
        certificate: its own, which everybody knows.
        key: what it signs with.
    """

    def __init__(self, certificate: x509.Certificate, key: ec.EllipticCurvePrivateKey) -> None:
        self._certificate = certificate
        self._key = key

    @classmethod
    def made(cls, name: str, valid: Validity) -> "Authority":
        """A new one, with a new key."""
        key = ec.generate_private_key(ec.SECP256R1())
        own = _named(name)
        builder = _builder(own, own, key.public_key(), valid)
        builder = builder.add_extension(x509.BasicConstraints(ca=True, path_length=0), True)
        builder = builder.add_extension(_usage(signs_certificates=True), True)
        return cls(builder.sign(key, hashes.SHA256()), key)

    @classmethod
    def of_pem(cls, certificate: bytes, key: bytes) -> "Authority":
        """One that was kept.

        Raises:
            ValueError: it is no certificate or no key.
        """
        loaded = serialization.load_pem_private_key(key, None)
        if not isinstance(loaded, ec.EllipticCurvePrivateKey):
            raise ValueError("expected a key on a curve")
        return cls(x509.load_pem_x509_certificate(certificate), loaded)

    @property
    def identity(self) -> Identity:
        """Its own certificate and key."""
        return Identity(_pem(self._certificate), _key_pem(self._key))

    def issue(self, name: str, valid: Validity, hosts: Sequence[str] = ()) -> Identity:
        """A certificate for a role, with a new key.

        Args:
            name: the common name, at most 64 characters.
            valid: from when to when.
            hosts: addresses and names of a door; none for everybody else.
        """
        key = ec.generate_private_key(ec.SECP256R1())
        issuer = self._certificate.subject
        builder = _builder(_named(name), issuer, key.public_key(), valid)
        builder = builder.add_extension(x509.BasicConstraints(ca=False, path_length=None), True)
        builder = builder.add_extension(_usage(signs_certificates=False), True)
        purposes = [ExtendedKeyUsageOID.CLIENT_AUTH]
        if hosts:
            purposes.append(ExtendedKeyUsageOID.SERVER_AUTH)
            names = x509.SubjectAlternativeName([alternative_name(host) for host in hosts])
            builder = builder.add_extension(names, False)
        builder = builder.add_extension(x509.ExtendedKeyUsage(purposes), False)
        public = self._certificate.extensions.get_extension_for_class(x509.SubjectKeyIdentifier)
        of_issuer = x509.AuthorityKeyIdentifier.from_issuer_subject_key_identifier(public.value)
        builder = builder.add_extension(of_issuer, False)
        return Identity(_pem(builder.sign(self._key, hashes.SHA256())), _key_pem(key))


def alternative_name(host: str) -> Name:
    """An address or a name, as a certificate says it."""
    try:
        return x509.IPAddress(ipaddress.ip_address(host))
    except ValueError:
        return x509.DNSName(host)


def _builder(
    subject: x509.Name, issuer: x509.Name, public: ec.EllipticCurvePublicKey, valid: Validity
) -> x509.CertificateBuilder:
    builder = x509.CertificateBuilder(issuer, subject, public, x509.random_serial_number())
    builder = builder.not_valid_before(valid.start).not_valid_after(valid.end)
    return builder.add_extension(x509.SubjectKeyIdentifier.from_public_key(public), False)


def _named(common_name: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common_name)])


def _usage(*, signs_certificates: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=not signs_certificates,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=signs_certificates,
        crl_sign=signs_certificates,
        encipher_only=False,
        decipher_only=False,
    )


def _pem(certificate: x509.Certificate) -> bytes:
    return certificate.public_bytes(serialization.Encoding.PEM)


def _key_pem(key: ec.EllipticCurvePrivateKey) -> bytes:
    return key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
