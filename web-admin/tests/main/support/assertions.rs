//! Assertions by which a client authenticates at a provider (RFC 7523), as the provider checks them.

use std::collections::{BTreeMap, BTreeSet};

use data_encoding::BASE64URL_NOPAD;
use ring::signature::{RSA_PKCS1_2048_8192_SHA256, RsaPublicKeyComponents};
use serde_json::Value;

/// Ids of the assertions that were used.
#[derive(Default)]
pub struct Assertions(BTreeSet<String>);

/// What an assertion must agree with.
pub struct ExpectedAssertion<'a> {
    pub client_id: &'a str,
    /// The client's key set.
    pub keys: &'a Value,
    pub audience: &'a str,
    pub now_s: i64,
}

impl Assertions {
    /// Uses the assertion of a form; whether it authenticates the client.
    pub fn take(&mut self, form: &BTreeMap<String, String>, expected: ExpectedAssertion<'_>) -> bool {
        let field = |name: &str| form.get(name).map(String::as_str).unwrap_or_default();
        let is_assertion = field("client_assertion_type") == "urn:ietf:params:oauth:client-assertion-type:jwt-bearer";
        let claims = read_signed(field("client_assertion"), expected.keys);
        let Some(claims) = claims.filter(|_| is_assertion) else { return false };
        let is = |name: &str, value: &str| claims[name] == value;
        let time_s = |name: &str| claims[name].as_i64().unwrap_or_default();
        let is_fresh =
            time_s("iat") <= expected.now_s && (expected.now_s..=expected.now_s + 300).contains(&time_s("exp"));
        let id = claims["jti"].as_str().unwrap_or_default();
        let is_new = id.len() >= 22 && self.0.insert(id.to_owned());
        is_fresh
            && is_new
            && is("iss", expected.client_id)
            && is("sub", expected.client_id)
            && is("aud", expected.audience)
    }
}

/// Returns the claims of a token that a key of the set has signed with RS256.
pub fn read_signed(token: &str, keys: &Value) -> Option<Value> {
    let (signed, signature) = token.rsplit_once('.')?;
    let (header, claims) = signed.split_once('.')?;
    let decode = |text: &str| BASE64URL_NOPAD.decode(text.as_bytes()).ok();
    let json = |text: &str| serde_json::from_slice::<Value>(&decode(text)?).ok();
    let header = json(header).filter(|header| header["alg"] == "RS256")?;
    let key = keys["keys"].as_array()?.iter().find(|key| key["kid"] == header["kid"])?;
    let [n, e] = ["n", "e"].map(|name| decode(key[name].as_str()?));
    let key = RsaPublicKeyComponents { n: n?, e: e? };
    key.verify(&RSA_PKCS1_2048_8192_SHA256, signed.as_bytes(), &decode(signature)?).ok()?;
    json(claims)
}
