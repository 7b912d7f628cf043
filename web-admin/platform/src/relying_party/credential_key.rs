//! Public keys of credentials: parsed from COSE (RFC 9052, RFC 9053), stored as JSON, and used to
//! verify signatures.

use ring::agreement::{self, ECDH_P256, ECDH_P384, EphemeralPrivateKey};
use ring::rand::SystemRandom;
use ring::signature::{
    ECDSA_P256_SHA256_ASN1, ECDSA_P384_SHA384_ASN1, RSA_PKCS1_2048_8192_SHA256, RsaPublicKeyComponents,
    UnparsedPublicKey,
};
use serde::{Deserialize, Serialize};

use super::base64url;
use super::cbor::{CborItem, CborMap};
use super::violation::Violation;

/// Offered algorithms by COSE number, in order of preference: ES256, ES384 and RS256.
pub(super) const OFFERED: [i64; 3] = [-7, -35, -257];

/// Length of an RSA modulus, in bytes.
const MODULUS: usize = 256;

/// The public key of a credential. Its JSON format is that of webauthn-rs 0.6, which wrote the
/// databases of earlier versions.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct CredentialKey {
    #[serde(rename = "type_")]
    algorithm: CoseAlgorithm,
    key: KeyMaterial,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum CoseAlgorithm {
    #[serde(rename = "ES256")]
    Es256,
    #[serde(rename = "ES384")]
    Es384,
    #[serde(rename = "RS256")]
    Rs256,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum KeyMaterial {
    #[serde(rename = "EC_EC2")]
    Point(EllipticPoint),
    #[serde(rename = "RSA")]
    Rsa {
        #[serde(with = "base64url")]
        n: Vec<u8>,
        e: [u8; 3],
    },
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct EllipticPoint {
    curve: EllipticCurve,
    #[serde(with = "base64url")]
    x: Vec<u8>,
    #[serde(with = "base64url")]
    y: Vec<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum EllipticCurve {
    #[serde(rename = "SECP256R1")]
    P256,
    #[serde(rename = "SECP384R1")]
    P384,
}

impl EllipticCurve {
    /// Length of a coordinate, in bytes.
    const fn coordinate(self) -> usize {
        match self {
            Self::P256 => 32,
            Self::P384 => 48,
        }
    }

    fn agreement(self) -> &'static agreement::Algorithm {
        match self {
            Self::P256 => &ECDH_P256,
            Self::P384 => &ECDH_P384,
        }
    }
}

impl EllipticPoint {
    fn read(curve: EllipticCurve, key: &CborMap<'_>) -> Option<Self> {
        let coordinate = |label| bytes(key, label).filter(|bytes| bytes.len() == curve.coordinate());
        let point = Self { curve, x: coordinate(-2)?.to_vec(), y: coordinate(-3)?.to_vec() };
        point.is_on_curve().then_some(point)
    }

    /// Returns the point in the uncompressed format of SEC 1.
    fn uncompressed(&self) -> Vec<u8> {
        [&[4], self.x.as_slice(), &self.y].concat()
    }

    /// Returns whether the point is on the curve. `ring` has no function for this, but a key
    /// agreement with a throw-away key fails if it is not.
    fn is_on_curve(&self) -> bool {
        let point = agreement::UnparsedPublicKey::new(self.curve.agreement(), self.uncompressed());
        EphemeralPrivateKey::generate(self.curve.agreement(), &SystemRandom::new())
            .is_ok_and(|key| agreement::agree_ephemeral(key, &point, |_| ()).is_ok())
    }
}

fn integer(key: &CborMap<'_>, label: i64) -> Option<i64> {
    match key.get(&CborItem::Integer(label)) {
        Some(CborItem::Integer(value)) => Some(*value),
        _ => None,
    }
}

fn bytes<'a>(key: &CborMap<'a>, label: i64) -> Option<&'a [u8]> {
    match key.get(&CborItem::Integer(label)) {
        Some(CborItem::Bytes(bytes)) => Some(*bytes),
        _ => None,
    }
}

impl CredentialKey {
    /// Parses a COSE_Key: its type (1), algorithm (3), and the parameters of both (-1, -2 and -3).
    /// WebAuthn, section 5.8.5, binds each algorithm to one curve.
    pub(super) fn read(key: &CborMap<'_>) -> Result<Self, Violation> {
        let point = |curve| EllipticPoint::read(curve, key).map(KeyMaterial::Point).ok_or(Violation::PublicKey);
        let algorithm = integer(key, 3).filter(|algorithm| OFFERED.contains(algorithm)).ok_or(Violation::Algorithm)?;
        Ok(match (algorithm, integer(key, 1), integer(key, -1)) {
            (-7, Some(2), Some(1)) => Self { algorithm: CoseAlgorithm::Es256, key: point(EllipticCurve::P256)? },
            (-35, Some(2), Some(2)) => Self { algorithm: CoseAlgorithm::Es384, key: point(EllipticCurve::P384)? },
            (-257, Some(3), None) => {
                let n = bytes(key, -1).filter(|n| n.len() == MODULUS).ok_or(Violation::PublicKey)?.to_vec();
                let e = bytes(key, -2).and_then(|e| e.try_into().ok()).ok_or(Violation::PublicKey)?;
                Self { algorithm: CoseAlgorithm::Rs256, key: KeyMaterial::Rsa { n, e } }
            }
            _ => return Err(Violation::PublicKey),
        })
    }

    /// Verifies a signature of a message.
    pub(super) fn verify(&self, message: &[u8], signature: &[u8]) -> Result<(), Violation> {
        let verified = match (self.algorithm, &self.key) {
            (CoseAlgorithm::Es256, KeyMaterial::Point(point)) if point.curve == EllipticCurve::P256 => {
                UnparsedPublicKey::new(&ECDSA_P256_SHA256_ASN1, point.uncompressed()).verify(message, signature)
            }
            (CoseAlgorithm::Es384, KeyMaterial::Point(point)) if point.curve == EllipticCurve::P384 => {
                UnparsedPublicKey::new(&ECDSA_P384_SHA384_ASN1, point.uncompressed()).verify(message, signature)
            }
            (CoseAlgorithm::Rs256, KeyMaterial::Rsa { n, e }) => {
                RsaPublicKeyComponents { n: n.as_slice(), e: e.as_slice() }.verify(
                    &RSA_PKCS1_2048_8192_SHA256,
                    message,
                    signature,
                )
            }
            _ => return Err(Violation::PublicKey),
        };
        verified.map_err(|_| Violation::Signature)
    }
}
