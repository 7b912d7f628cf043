//! Keys of an OpenID provider: they sign tokens, and publish themselves as a JSON Web Key.

use data_encoding::BASE64URL_NOPAD;
use ring::rand::SystemRandom;
use ring::rsa::PublicKeyComponents;
use ring::signature::{
    ECDSA_P256_SHA256_FIXED_SIGNING, ECDSA_P384_SHA384_FIXED_SIGNING, EcdsaKeyPair, EcdsaSigningAlgorithm,
    Ed25519KeyPair, KeyPair, RSA_PKCS1_SHA256, RSA_PSS_SHA256, RsaEncoding, RsaKeyPair,
};
use serde_json::{Value, json};

/// An RSA key of 2048 bits: `ring` generates none. `openssl genpkey -algorithm RSA -pkeyopt rsa_keygen_bits:2048 -outform DER`.
const RSA: &[u8] = include_bytes!("../../data/federation/rsa.pk8");

/// A signature algorithm that the service accepts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    Rs256,
    Ps256,
    Es256,
    Es384,
    EdDsa,
}

impl Algorithm {
    pub const ALL: [Self; 5] = [Self::Rs256, Self::Ps256, Self::Es256, Self::Es384, Self::EdDsa];

    pub fn name(self) -> &'static str {
        match self {
            Self::Rs256 => "RS256",
            Self::Ps256 => "PS256",
            Self::Es256 => "ES256",
            Self::Es384 => "ES384",
            Self::EdDsa => "EdDSA",
        }
    }
}

enum PrivateKey {
    Rsa(RsaKeyPair, &'static dyn RsaEncoding),
    Elliptic(EcdsaKeyPair),
    Edwards(Ed25519KeyPair),
}

/// A signing key with its id.
pub struct Signer {
    pub kid: String,
    pub algorithm: Algorithm,
    key: PrivateKey,
}

impl Signer {
    /// Makes a key; the RSA key is always the same.
    pub fn new(kid: &str, algorithm: Algorithm) -> Self {
        let key = match algorithm {
            Algorithm::Rs256 => PrivateKey::Rsa(RsaKeyPair::from_pkcs8(RSA).unwrap(), &RSA_PKCS1_SHA256),
            Algorithm::Ps256 => PrivateKey::Rsa(RsaKeyPair::from_pkcs8(RSA).unwrap(), &RSA_PSS_SHA256),
            Algorithm::Es256 => elliptic(&ECDSA_P256_SHA256_FIXED_SIGNING),
            Algorithm::Es384 => elliptic(&ECDSA_P384_SHA384_FIXED_SIGNING),
            Algorithm::EdDsa => {
                let document = Ed25519KeyPair::generate_pkcs8(&SystemRandom::new()).unwrap();
                PrivateKey::Edwards(Ed25519KeyPair::from_pkcs8(document.as_ref()).unwrap())
            }
        };
        Self { kid: kid.to_owned(), algorithm, key }
    }

    pub fn sign(&self, message: &[u8]) -> Vec<u8> {
        match &self.key {
            PrivateKey::Rsa(key, padding) => {
                let mut signature = vec![0; key.public().modulus_len()];
                key.sign(*padding, &SystemRandom::new(), message, &mut signature).unwrap();
                signature
            }
            PrivateKey::Elliptic(key) => key.sign(&SystemRandom::new(), message).unwrap().as_ref().to_vec(),
            PrivateKey::Edwards(key) => key.sign(message).as_ref().to_vec(),
        }
    }

    /// Returns the bytes of the public key, which everybody knows.
    pub fn public_bytes(&self) -> &[u8] {
        match &self.key {
            PrivateKey::Rsa(key, _) => key.public().as_ref(),
            PrivateKey::Elliptic(key) => key.public_key().as_ref(),
            PrivateKey::Edwards(key) => key.public_key().as_ref(),
        }
    }

    /// Returns the public key as a member of a key set.
    pub fn public_key(&self) -> Value {
        let mut key = match &self.key {
            PrivateKey::Rsa(key, _) => {
                let public = PublicKeyComponents::<Vec<u8>>::from(key.public());
                json!({ "kty": "RSA", "n": encode(&public.n), "e": encode(&public.e) })
            }
            PrivateKey::Elliptic(key) => {
                let point = &key.public_key().as_ref()[1..];
                let (x, y) = point.split_at(point.len() / 2);
                let curve = if x.len() == 32 { "P-256" } else { "P-384" };
                json!({ "kty": "EC", "crv": curve, "x": encode(x), "y": encode(y) })
            }
            PrivateKey::Edwards(key) => {
                json!({ "kty": "OKP", "crv": "Ed25519", "x": encode(key.public_key().as_ref()) })
            }
        };
        key["kid"] = json!(self.kid);
        key["alg"] = json!(self.algorithm.name());
        key["use"] = json!("sig");
        key
    }
}

fn elliptic(algorithm: &'static EcdsaSigningAlgorithm) -> PrivateKey {
    let random = SystemRandom::new();
    let document = EcdsaKeyPair::generate_pkcs8(algorithm, &random).unwrap();
    PrivateKey::Elliptic(EcdsaKeyPair::from_pkcs8(algorithm, document.as_ref(), &random).unwrap())
}

/// Returns bytes in URL-safe base64 without padding.
pub fn encode(bytes: &[u8]) -> String {
    BASE64URL_NOPAD.encode(bytes)
}
