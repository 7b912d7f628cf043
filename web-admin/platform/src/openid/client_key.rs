//! Keys with which this service authenticates as a client (`private_key_jwt`: OpenID Connect Core
//! 1.0, section 9; RFC 7523).

use anyhow::{Context, anyhow};
use data_encoding::BASE64URL_NOPAD;
use ring::rand::SystemRandom;
use ring::rsa::{KeyPairComponents, PublicKeyComponents};
use ring::signature::{RSA_PKCS1_SHA256, RsaKeyPair};
use rsa::traits::{PrivateKeyParts, PublicKeyParts};
use rsa::{BoxedUint, Generate, PrivateKey};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use crate::secret;

/// Lifetime of an assertion, in s.
const ASSERTION_LIFETIME_S: i64 = 60;
/// Value of the parameter `client_assertion_type` (RFC 7523, section 2.2).
pub const ASSERTION_TYPE: &str = "urn:ietf:params:oauth:client-assertion-type:jwt-bearer";

/// The private numbers of an RSA key, named as in a JSON Web Key (RFC 7518, section 6.3) and
/// base64url-encoded.
#[derive(Serialize, Deserialize)]
struct PrivateNumbers {
    n: String,
    e: String,
    d: String,
    p: String,
    q: String,
    dp: String,
    dq: String,
    qi: String,
}

/// A new key pair.
#[derive(Clone, Debug)]
pub struct NewClientKey {
    /// Id: the thumbprint of the public key (RFC 7638).
    pub kid: String,
    /// The private key, as JSON.
    pub private: Vec<u8>,
    /// The public key as a JSON Web Key.
    pub public: Value,
}

impl NewClientKey {
    /// Generates an RSA key pair of 3072 bits; takes up to some seconds.
    ///
    /// # Errors
    /// Fails if the operating system's random source fails.
    pub fn generate() -> anyhow::Result<Self> {
        let key = PrivateKey::try_generate()?;
        let encode = |number: &BoxedUint| BASE64URL_NOPAD.encode(&number.to_be_bytes_trimmed_vartime());
        let [p, q] = key.primes() else { return Err(anyhow!("an RSA key without two primes")) };
        let (dp, dq, qi) = (key.dp().zip(key.dq()).zip(key.qinv()))
            .map(|((dp, dq), qi)| (encode(dp), encode(dq), encode(&qi.retrieve())))
            .context("an RSA key without its precomputed numbers")?;
        let (n, e) = (encode(key.n()), encode(key.e()));
        let thumbprint = Sha256::digest(format!(r#"{{"e":"{e}","kty":"RSA","n":"{n}"}}"#));
        let kid = BASE64URL_NOPAD.encode(&thumbprint);
        let public = json!({ "kty": "RSA", "use": "sig", "alg": "RS256", "kid": kid, "n": n, "e": e });
        let private = PrivateNumbers { n, e, d: encode(key.d()), p: encode(p), q: encode(q), dp, dq, qi };
        Ok(Self { kid, private: serde_json::to_vec(&private)?, public })
    }
}

/// A key that signs.
#[derive(Debug)]
pub struct ClientKey {
    kid: String,
    pair: RsaKeyPair,
}

impl ClientKey {
    /// Reads the private key of a [`NewClientKey`].
    ///
    /// # Errors
    /// Fails if it is malformed.
    pub fn read(kid: &str, private: &[u8]) -> anyhow::Result<Self> {
        let numbers: PrivateNumbers = serde_json::from_slice(private)?;
        let decode = |text: &String| BASE64URL_NOPAD.decode(text.as_bytes());
        let components = KeyPairComponents {
            public_key: PublicKeyComponents { n: decode(&numbers.n)?, e: decode(&numbers.e)? },
            d: decode(&numbers.d)?,
            p: decode(&numbers.p)?,
            q: decode(&numbers.q)?,
            dP: decode(&numbers.dp)?,
            dQ: decode(&numbers.dq)?,
            qInv: decode(&numbers.qi)?,
        };
        let pair = RsaKeyPair::from_components(&components).map_err(|error| anyhow!("key {kid}: {error}"))?;
        Ok(Self { kid: kid.to_owned(), pair })
    }

    /// Returns a signed JSON Web Token (RS256).
    ///
    /// # Errors
    /// Fails if the operating system's random source fails.
    pub fn sign(&self, claims: &Value) -> anyhow::Result<String> {
        let header = json!({ "typ": "JWT", "alg": "RS256", "kid": self.kid });
        let [header, claims] = [&header, claims].map(|part| BASE64URL_NOPAD.encode(part.to_string().as_bytes()));
        let signed = format!("{header}.{claims}");
        let mut signature = vec![0; self.pair.public().modulus_len()];
        let done = self.pair.sign(&RSA_PKCS1_SHA256, &SystemRandom::new(), signed.as_bytes(), &mut signature);
        done.ok().context("a token could not be signed")?;
        Ok(format!("{signed}.{}", BASE64URL_NOPAD.encode(&signature)))
    }

    /// Returns an assertion that authenticates this service at a token endpoint.
    ///
    /// # Errors
    /// Fails if the operating system's random source fails.
    pub fn sign_assertion(&self, client_id: &str, token_endpoint: &str, now_s: i64) -> anyhow::Result<String> {
        self.sign(&json!({
            "iss": client_id, "sub": client_id, "aud": token_endpoint, "jti": secret::random_hex()?,
            "iat": now_s, "exp": now_s + ASSERTION_LIFETIME_S,
        }))
    }
}
