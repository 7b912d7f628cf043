//! A security key in software: makes ES256 passkeys and signs with them, as WebAuthn says, and as wrongly as it is told.

use std::sync::Arc;

use data_encoding::BASE64URL_NOPAD;
use ring::rand::SystemRandom;
use ring::signature::{ECDSA_P256_SHA256_ASN1_SIGNING, EcdsaKeyPair, KeyPair};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

const PRESENT: u8 = 1;
const VERIFIED: u8 = 1 << 2;
const NEW_KEY: u8 = 1 << 6;

/// A security key with one passkey.
#[derive(Clone)]
pub struct Authenticator {
    key: Arc<EcdsaKeyPair>,
    id: [u8; 16],
    /// Signatures counted; 0 for ever where `counts` is false.
    pub count: u32,
    pub counts: bool,
    /// The page that the browser says has asked.
    pub origin: String,
    /// The owner was recognised.
    pub verifies: bool,
}

impl Authenticator {
    /// One with a new key, whose id is a number.
    pub fn new(number: u8, origin: &str) -> Self {
        let (algorithm, random) = (&ECDSA_P256_SHA256_ASN1_SIGNING, SystemRandom::new());
        let document = EcdsaKeyPair::generate_pkcs8(algorithm, &random).unwrap();
        let key = Arc::new(EcdsaKeyPair::from_pkcs8(algorithm, document.as_ref(), &random).unwrap());
        Self { key, id: [number; 16], count: 0, counts: true, origin: origin.to_owned(), verifies: true }
    }

    /// Makes its passkey as a page asks; the answer as the page sends it.
    pub fn make(&mut self, options: &Value) -> Value {
        let asked = &options["publicKey"];
        let client = self.client_data("webauthn.create", asked);
        let mut data = self.data(asked["rp"]["id"].as_str().unwrap(), NEW_KEY);
        data.extend([0; 16]);
        data.extend(u16::try_from(self.id.len()).unwrap().to_be_bytes());
        data.extend(self.id);
        data.extend(self.public_key());
        // A map of "fmt", "attStmt" and "authData" in CBOR.
        let mut attestation = b"\xa3\x63fmt\x64none\x67attStmt\xa0\x68authData\x58".to_vec();
        attestation.push(u8::try_from(data.len()).unwrap());
        attestation.extend(data);
        json!({
            "id": encoded(&self.id), "rawId": encoded(&self.id), "type": "public-key",
            "response": { "attestationObject": encoded(&attestation), "clientDataJSON": encoded(&client), "transports": ["usb"] },
        })
    }

    /// Signs what a page asks; the answer as the page sends it.
    pub fn sign(&mut self, options: &Value) -> Value {
        let asked = &options["publicKey"];
        let client = self.client_data("webauthn.get", asked);
        let data = self.data(asked["rpId"].as_str().unwrap(), 0);
        let signed = [&data[..], &Sha256::digest(&client)].concat();
        let signature = self.key.sign(&SystemRandom::new(), &signed).unwrap();
        json!({
            "id": encoded(&self.id), "rawId": encoded(&self.id), "type": "public-key",
            "response": { "authenticatorData": encoded(&data), "clientDataJSON": encoded(&client),
                "signature": encoded(signature.as_ref()), "userHandle": null },
        })
    }

    fn client_data(&self, act: &str, asked: &Value) -> Vec<u8> {
        json!({ "type": act, "challenge": asked["challenge"], "origin": self.origin, "crossOrigin": false })
            .to_string()
            .into_bytes()
    }

    fn data(&mut self, site: &str, more: u8) -> Vec<u8> {
        if self.counts {
            self.count += 1;
        }
        let mut data = Sha256::digest(site.as_bytes()).to_vec();
        data.push(PRESENT | if self.verifies { VERIFIED } else { 0 } | more);
        data.extend(self.count.to_be_bytes());
        data
    }

    /// As COSE writes it: an EC2 key for ES256 on P-256, x and y.
    fn public_key(&self) -> Vec<u8> {
        let (x, y) = self.key.public_key().as_ref()[1..].split_at(32);
        [b"\xa5\x01\x02\x03\x26\x20\x01\x21\x58\x20", x, b"\x22\x58\x20", y].concat()
    }
}

fn encoded(bytes: &[u8]) -> String {
    BASE64URL_NOPAD.encode(bytes)
}
