//! Responses with one error each: every rule of WebAuthn must be checked, valid responses must be
//! accepted, and records in the format of webauthn-rs must be readable.

use ring::rand::SystemRandom;
use ring::signature::{
    ECDSA_P256_SHA256_ASN1_SIGNING, ECDSA_P384_SHA384_ASN1_SIGNING, EcdsaKeyPair, EcdsaSigningAlgorithm, KeyPair,
};
use serde_json::Value;

use super::violation::Violation;
use super::*;

const HOST: &str = "training.example.org";
const ADA: PersonId = PersonId::from_u128(1);
const PRESENT_AND_VERIFIED: u8 = 0b101;
const ELIGIBLE: u8 = 1 << 3;
const BACKED_UP: u8 = 1 << 4;
const HAS_CREDENTIAL: u8 = 1 << 6;
const HAS_EXTENSIONS: u8 = 1 << 7;

fn party_of(public_url: Option<&str>, listen: &str) -> Option<RelyingParty> {
    let public_url = public_url.map(str::to_owned);
    let listen = listen.parse().unwrap();
    RelyingParty::of(&Config { public_url, listen, ..Config::in_folder(std::path::Path::new("x")) })
}

fn party() -> RelyingParty {
    party_of(Some("https://training.example.org"), "127.0.0.1:8080").unwrap()
}

/// Returns the challenge of all tests.
fn challenge() -> Challenge {
    Challenge(BASE64URL_NOPAD.encode(&[42; 32]))
}

fn encoded(bytes: &[u8]) -> String {
    BASE64URL_NOPAD.encode(bytes)
}

fn new_key(algorithm: &'static EcdsaSigningAlgorithm) -> EcdsaKeyPair {
    let random = SystemRandom::new();
    let document = EcdsaKeyPair::generate_pkcs8(algorithm, &random).unwrap();
    EcdsaKeyPair::from_pkcs8(algorithm, document.as_ref(), &random).unwrap()
}

/// Returns the public key of a pair in COSE, for ES256 or ES384.
fn cose(key: &EcdsaKeyPair) -> Vec<u8> {
    let (x, y) = key.public_key().as_ref()[1..].split_at((key.public_key().as_ref().len() - 1) / 2);
    let (start, before_x, before_y): (&[u8], &[u8], &[u8]) = match x.len() {
        32 => (b"\xa5\x01\x02\x03\x26\x20\x01", b"\x21\x58\x20", b"\x22\x58\x20"),
        _ => (b"\xa5\x01\x02\x03\x38\x22\x20\x02", b"\x21\x58\x30", b"\x22\x58\x30"),
    };
    [start, before_x, x, before_y, y].concat()
}

/// A response that a test may change before it is signed and encoded.
struct Forgery {
    client: Value,
    /// Replaces `client` by something other than an object.
    client_json: Option<&'static str>,
    site: &'static str,
    flags: u8,
    count: u32,
    /// Id and key of the new credential, in a registration.
    id: Vec<u8>,
    cose: Vec<u8>,
    /// Bytes after it: extensions, or excess bytes.
    tail: Vec<u8>,
    /// Builds the attestation object.
    object: fn(&[u8]) -> Vec<u8>,
    /// Changes the authenticator data after it was signed.
    afterwards: fn(&mut Vec<u8>),
    /// Changes the whole response.
    answer: fn(&mut Value),
}

impl Forgery {
    /// Returns a valid response.
    fn none(kind: &str, flags: u8) -> Self {
        Self {
            client: json!({ "type": kind, "challenge": challenge(), "origin": "https://training.example.org", "crossOrigin": false }),
            client_json: None,
            site: HOST,
            flags: PRESENT_AND_VERIFIED | flags,
            count: 1,
            id: vec![7; 16],
            cose: Vec::new(),
            tail: Vec::new(),
            object: |data| object(b"\xa3", data),
            afterwards: |_| (),
            answer: |_| (),
        }
    }

    fn client_data(&self) -> Vec<u8> {
        self.client_json.map_or_else(|| self.client.to_string(), str::to_owned).into_bytes()
    }

    fn data(&self) -> Vec<u8> {
        let mut data = sha256(self.site.as_bytes()).to_vec();
        data.push(self.flags);
        data.extend(self.count.to_be_bytes());
        if self.flags & HAS_CREDENTIAL != 0 {
            data.extend([0; 16]);
            data.extend(u16::try_from(self.id.len()).unwrap().to_be_bytes());
            data.extend([self.id.as_slice(), &self.cose].concat());
        }
        data.extend(&self.tail);
        data
    }

    fn registration(&self) -> String {
        let response = json!({ "clientDataJSON": encoded(&self.client_data()), "attestationObject": encoded(&(self.object)(&self.data())) });
        self.whole(response)
    }

    fn assertion(&self, key: &EcdsaKeyPair) -> String {
        let (client, mut data) = (self.client_data(), self.data());
        let signed = [data.as_slice(), &sha256(&client)].concat();
        let signature = key.sign(&SystemRandom::new(), &signed).unwrap();
        (self.afterwards)(&mut data);
        self.whole(json!({ "clientDataJSON": encoded(&client), "authenticatorData": encoded(&data),
            "signature": encoded(signature.as_ref()), "userHandle": null }))
    }

    fn whole(&self, response: Value) -> String {
        let id = encoded(&self.id);
        let mut answer = json!({ "id": id, "rawId": id, "type": "public-key", "response": response });
        (self.answer)(&mut answer);
        answer.to_string()
    }
}

/// Returns an attestation object without a statement, starting with the bytes `start`.
fn object(start: &[u8], data: &[u8]) -> Vec<u8> {
    [start, b"\x63fmt\x64none\x67attStmt\xa0", &authenticator_data(data)].concat()
}

fn authenticator_data(data: &[u8]) -> Vec<u8> {
    [b"\x68authData\x59".as_slice(), &u16::try_from(data.len()).unwrap().to_be_bytes(), data].concat()
}

/// Returns an attestation object whose statement is an item nested in this many arrays.
fn nested(levels: usize, data: &[u8]) -> Vec<u8> {
    let statement = [b"\x81".repeat(levels), b"\x00".to_vec()].concat();
    [b"\xa3\x63fmt\x64none\x67attStmt", statement.as_slice(), &authenticator_data(data)].concat()
}

type Change = fn(&mut Forgery);

const OF_THE_CLIENT: [(Change, Violation); 14] = [
    (|forged| forged.client["type"] = json!("webauthn.other"), Violation::Type),
    (|forged| forged.client["challenge"] = json!(Challenge(encoded(&[41; 32]))), Violation::Challenge),
    (|forged| forged.client["challenge"] = json!(""), Violation::Challenge),
    (|forged| forged.client["challenge"] = json!(format!("{}=", challenge().0)), Violation::Challenge),
    (|forged| forged.client["origin"] = json!("https://training.example.com"), Violation::Origin),
    (|forged| forged.client["origin"] = json!("http://training.example.org"), Violation::Origin),
    (|forged| forged.client["origin"] = json!("https://a.training.example.org"), Violation::Origin),
    (|forged| forged.client["origin"] = json!("https://training.example.org:8443"), Violation::Origin),
    (|forged| forged.client["origin"] = json!("https://training.example.org/"), Violation::Origin),
    (|forged| forged.client["crossOrigin"] = json!(true), Violation::CrossOrigin),
    (|forged| forged.client["topOrigin"] = json!("https://example.com"), Violation::CrossOrigin),
    (|forged| forged.client["origin"] = json!(null), Violation::ClientData),
    (
        |forged| forged.client_json = Some("{\"type\":\"webauthn.create\",\"type\":\"webauthn.get\"}"),
        Violation::ClientData,
    ),
    (|forged| forged.client_json = Some("\u{feff}{}"), Violation::ClientData),
];

const OF_THE_AUTHENTICATOR: [(Change, Violation); 8] = [
    (|forged| forged.site = "example.org", Violation::RelyingParty),
    (|forged| forged.flags &= !1, Violation::NotPresent),
    (|forged| forged.flags &= !0b100, Violation::NotVerified),
    (|forged| forged.flags |= BACKED_UP, Violation::Backup),
    (|forged| forged.flags ^= HAS_CREDENTIAL, Violation::Ceremony),
    (|forged| forged.flags |= HAS_EXTENSIONS, Violation::AuthenticatorData),
    (|forged| forged.tail = vec![0], Violation::AuthenticatorData),
    (|forged| forged.answer = |answer| answer["type"] = json!("password"), Violation::Answer),
];

fn new_registration(key: &EcdsaKeyPair) -> Forgery {
    Forgery { cose: cose(key), ..Forgery::none("webauthn.create", HAS_CREDENTIAL) }
}

#[test]
fn a_registration_violates_no_rule() {
    let key = new_key(&ECDSA_P256_SHA256_ASN1_SIGNING);
    let of_the_credential: [(Change, Violation); 16] = [
        (|forged| forged.id.clear(), Violation::CredentialId),
        (|forged| forged.id = vec![7; 1024], Violation::CredentialId),
        // EdDSA, by its COSE number.
        (|forged| forged.cose[4] = 0x27, Violation::Algorithm),
        (|forged| forged.cose[2] = 0x03, Violation::PublicKey),
        (|forged| forged.cose[6] = 0x02, Violation::PublicKey),
        (|forged| forged.cose[20] ^= 1, Violation::PublicKey),
        (|forged| forged.cose[10..42].fill(0), Violation::PublicKey),
        // A coordinate of 31 bytes.
        (|forged| drop(forged.cose.splice(9..11, [0x1f])), Violation::PublicKey),
        // Two x coordinates, and no y.
        (|forged| forged.cose[42] = 0x21, Violation::AuthenticatorData),
        (|forged| forged.cose = b"\xa1\x03\x26".to_vec(), Violation::PublicKey),
        (|forged| forged.cose = b"\xa0".to_vec(), Violation::Algorithm),
        (|forged| forged.object = |data| [object(b"\xa3", data), vec![0]].concat(), Violation::AttestationObject),
        (|forged| forged.object = |data| object(b"\xa4\x63fmt\x64none", data), Violation::AttestationObject),
        (
            |forged| forged.object = |data| [b"\xa1".as_slice(), &authenticator_data(data)].concat(),
            Violation::AttestationObject,
        ),
        (|forged| forged.object = |data| nested(1_000_000, data), Violation::AttestationObject),
        (|forged| forged.answer = |answer| answer["response"]["attestationObject"] = json!("oA=="), Violation::Answer),
    ];
    for (number, (change, expected)) in
        OF_THE_CLIENT.into_iter().chain(OF_THE_AUTHENTICATOR).chain(of_the_credential).enumerate()
    {
        let mut forged = new_registration(&key);
        change(&mut forged);
        let refused = party().register(&forged.registration(), &challenge()).err();
        assert_eq!(refused, Some(expected), "forgery {number}");
    }
}

#[test]
fn a_registration_makes_a_record() {
    let key = new_key(&ECDSA_P256_SHA256_ASN1_SIGNING);
    let valid: [Change; 6] = [
        |_| (),
        |forged| forged.id = vec![7; 1023],
        |forged| forged.flags |= ELIGIBLE | BACKED_UP,
        |forged| forged.object = |data| nested(5, data),
        |forged| forged.client["unknown"] = json!({ "member": [1] }),
        // {"credProtect": 3}
        |forged| {
            forged.flags |= HAS_EXTENSIONS;
            forged.tail = b"\xa1\x6bcredProtect\x03".to_vec();
        },
    ];
    for (number, change) in valid.into_iter().enumerate() {
        let mut answer = new_registration(&key);
        change(&mut answer);
        let record = party().register(&answer.registration(), &challenge()).unwrap();
        assert_eq!((record.id(), record.sign_count()), (answer.id.as_slice(), 1), "{number}");
        assert_eq!(record.backup_state, answer.flags & BACKED_UP != 0, "{number}");
    }
}

#[test]
fn authenticator_data_that_ends_early_is_refused() {
    let key = new_key(&ECDSA_P256_SHA256_ASN1_SIGNING);
    let data = new_registration(&key).data();
    for length in 0..data.len() {
        let read = authenticator_data::AuthenticatorData::read(&data[..length]);
        assert_eq!(read.err(), Some(Violation::AuthenticatorData), "{length} bytes");
    }
    assert!(authenticator_data::AuthenticatorData::read(&data).is_ok());
}

/// Returns a credential of Ada's that has signed once, with its key.
fn credential(algorithm: &'static EcdsaSigningAlgorithm) -> (EcdsaKeyPair, CredentialRecord) {
    let key = new_key(algorithm);
    let record = party().register(&new_registration(&key).registration(), &challenge()).unwrap();
    (key, record)
}

fn new_assertion() -> Forgery {
    Forgery { count: 2, ..Forgery::none("webauthn.get", 0) }
}

fn authenticate(answer: &str, record: &CredentialRecord) -> Result<CredentialRecord, Violation> {
    let (request, _) = party().request_options(challenge(), std::slice::from_ref(record));
    let account = PasskeyAccount { person_id: ADA, records: std::slice::from_ref(record) };
    party().authenticate(answer, &request, account)
}

#[test]
fn an_assertion_violates_no_rule() {
    let (key, record) = credential(&ECDSA_P256_SHA256_ASN1_SIGNING);
    let of_the_signature: [(Change, Violation); 9] = [
        (|forged| forged.count = 1, Violation::SignCount),
        (|forged| forged.count = 0, Violation::SignCount),
        // Changed after signing: the signature counter, and the flag for backup eligibility.
        (|forged| forged.afterwards = |data| data[36] += 1, Violation::Signature),
        (|forged| forged.afterwards = |data| data[32] |= ELIGIBLE, Violation::Signature),
        (|forged| forged.afterwards = |data| data.truncate(36), Violation::AuthenticatorData),
        (|forged| forged.answer = |answer| answer["response"]["signature"] = json!(""), Violation::Signature),
        (|forged| forged.id = vec![8; 16], Violation::NotAllowed),
        (
            |forged| {
                forged.answer = |answer| answer["response"]["userHandle"] = json!(user_handle(PersonId::from_u128(2)))
            },
            Violation::UserHandle,
        ),
        (|forged| forged.answer = |answer| answer["rawId"] = json!(1), Violation::Answer),
    ];
    for (number, (change, expected)) in
        OF_THE_CLIENT.into_iter().chain(OF_THE_AUTHENTICATOR).chain(of_the_signature).enumerate()
    {
        let mut forged = Forgery { cose: cose(&key), ..new_assertion() };
        change(&mut forged);
        assert_eq!(authenticate(&forged.assertion(&key), &record).err(), Some(expected), "forgery {number}");
    }
    let another = new_key(&ECDSA_P256_SHA256_ASN1_SIGNING);
    assert_eq!(authenticate(&new_assertion().assertion(&another), &record).err(), Some(Violation::Signature));
    let longer = new_key(&ECDSA_P384_SHA384_ASN1_SIGNING);
    assert_eq!(authenticate(&new_assertion().assertion(&longer), &record).err(), Some(Violation::Signature));
}

#[test]
fn assertion_must_use_a_requested_credential_of_the_person() {
    let (key, record) = credential(&ECDSA_P256_SHA256_ASN1_SIGNING);
    let (answer, records) = (new_assertion().assertion(&key), std::slice::from_ref(&record));
    let (of_none, _) = party().request_options(challenge(), &[]);
    let (of_one, _) = party().request_options(challenge(), records);
    for (request, records, expected) in [
        (&of_one, records, None),
        (&of_none, records, Some(Violation::NotAllowed)),
        (&of_one, &[], Some(Violation::NotAllowed)),
    ] {
        let account = PasskeyAccount { person_id: ADA, records };
        assert_eq!(party().authenticate(&answer, request, account).err(), expected);
    }
}

#[test]
fn an_assertion_updates_its_record() {
    for algorithm in [&ECDSA_P256_SHA256_ASN1_SIGNING, &ECDSA_P384_SHA384_ASN1_SIGNING] {
        let (key, record) = credential(algorithm);
        let own: [fn(&mut Value); 3] = [
            |_| (),
            |answer| answer["response"]["userHandle"] = json!(user_handle(ADA)),
            |answer| answer["response"]["userHandle"] = json!(""),
        ];
        for answer in own {
            let signed = Forgery { answer, ..new_assertion() };
            assert_eq!(authenticate(&signed.assertion(&key), &record).unwrap().sign_count(), 2);
        }
    }
}

#[test]
fn a_credential_that_counts_nothing_goes_on() {
    let (key, mut record) = credential(&ECDSA_P256_SHA256_ASN1_SIGNING);
    record.sign_count = 0;
    let signed = Forgery { count: 0, ..new_assertion() };
    assert_eq!(authenticate(&signed.assertion(&key), &record).unwrap().sign_count(), 0);
}

#[test]
fn backups_go_one_way() {
    let (key, record) = credential(&ECDSA_P256_SHA256_ASN1_SIGNING);
    let sign = |record: &CredentialRecord, flags| {
        let signed = Forgery { flags: PRESENT_AND_VERIFIED | flags, ..new_assertion() };
        authenticate(&signed.assertion(&key), record).map(|record| (record.backup_eligible, record.backup_state))
    };
    assert_eq!(sign(&record, ELIGIBLE), Ok((true, false)), "its device has learnt it");
    assert_eq!(sign(&record, ELIGIBLE | BACKED_UP), Err(Violation::Backup));
    let eligible = CredentialRecord { backup_eligible: true, ..record };
    assert_eq!(sign(&eligible, ELIGIBLE | BACKED_UP), Ok((true, true)));
    assert_eq!(sign(&eligible, 0), Err(Violation::Backup));
}

#[test]
fn a_counter_that_goes_back_is_a_copy_and_nonsense_is_no_answer() {
    let (key, record) = credential(&ECDSA_P256_SHA256_ASN1_SIGNING);
    let (request, _) = party().request_options(challenge(), std::slice::from_ref(&record));
    let account = PasskeyAccount { person_id: ADA, records: std::slice::from_ref(&record) };
    let copied = Forgery { count: 1, ..new_assertion() }.assertion(&key);
    assert_eq!(party().verify_assertion(&copied, &request, account).err(), Some(AnswerRefused::Copied));
    for answer in ["", "{}", "null", "{\"id\": 1}", "\u{0}"] {
        assert_eq!(party().verify_registration(answer, &challenge()).err(), Some(AnswerRefused::Wrong), "{answer}");
        assert_eq!(party().verify_assertion(answer, &request, account).err(), Some(AnswerRefused::Wrong), "{answer}");
    }
}

#[test]
fn records_in_the_form_of_webauthn_rs_are_read_written_and_used() {
    let golden = include_str!("../../../../tests/data/passkeys/form-of-webauthn-rs-0.6.2.json");
    let golden: Vec<Value> = serde_json::from_str(golden).unwrap();
    assert_eq!(golden.len(), 4, "ES256 with and without a statement, ES384 and RS256");
    for case in golden {
        let record = CredentialRecord::from_json(&case["record"].to_string()).unwrap();
        let written: Value = serde_json::from_str(&record.to_json().unwrap()).unwrap();
        assert_eq!(written, case["record"], "{}", case["name"]);
        let signed = authenticate(&case["answer"].to_string(), &record);
        assert!(signed.is_ok(), "{}: {signed:?}", case["name"]);
        let mut forged = case["answer"].clone();
        let signature = forged["response"]["signature"].as_str().unwrap();
        forged["response"]["signature"] = json!(format!("{}AA", &signature[..signature.len() - 2]));
        assert_eq!(authenticate(&forged.to_string(), &record).err(), Some(Violation::Signature), "{}", case["name"]);
    }
}

#[test]
fn a_new_record_has_the_members_of_the_others() {
    let golden = include_str!("../../../../tests/data/passkeys/form-of-webauthn-rs-0.6.2.json");
    let golden: Vec<Value> = serde_json::from_str(golden).unwrap();
    let (_, record) = credential(&ECDSA_P256_SHA256_ASN1_SIGNING);
    let written: Value = serde_json::from_str(&record.to_json().unwrap()).unwrap();
    let members = |record: &Value| record["cred"].as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert_eq!(members(&written), members(&golden[0]["record"]));
    for member in ["user_verified", "registration_policy", "transports", "attestation", "attestation_format"] {
        assert_eq!(written["cred"][member], golden[0]["record"]["cred"][member], "{member}");
    }
}

#[test]
fn browsers_are_asked_as_before() {
    let (_, record) = credential(&ECDSA_P256_SHA256_ASN1_SIGNING);
    let owner = PasskeyOwner { id: ADA, email: "ada@example.org", name: "Ada" };
    let options = party().creation_options(owner, &challenge(), std::slice::from_ref(&record));
    let id = "BwcHBwcHBwcHBwcHBwcHBw";
    let expected = json!({ "publicKey": {
        "rp": { "name": "Stylet", "id": HOST },
        "user": { "id": "AAAAAAAAAAAAAAAAAAAAAQ", "name": "ada@example.org", "displayName": "Ada" },
        "challenge": challenge(),
        "pubKeyCredParams": [
            { "type": "public-key", "alg": -7 }, { "type": "public-key", "alg": -35 }, { "type": "public-key", "alg": -257 },
        ],
        "timeout": 300_000,
        "excludeCredentials": [{ "type": "public-key", "id": id }],
        "authenticatorSelection": { "residentKey": "discouraged", "requireResidentKey": false, "userVerification": "required" },
        "attestation": "none",
        "extensions": {
            "credentialProtectionPolicy": "userVerificationRequired", "enforceCredentialProtectionPolicy": false,
            "uvm": true, "credProps": true,
        },
    } });
    assert_eq!(serde_json::from_str::<Value>(&options).unwrap(), expected);
    let with_transports = CredentialRecord { transports: Some(vec!["usb".to_owned()]), ..record.clone() };
    let (_, options) = party().request_options(challenge(), &[record, with_transports]);
    let expected = json!({ "publicKey": {
        "challenge": challenge(), "timeout": 300_000, "rpId": HOST,
        "allowCredentials": [
            { "type": "public-key", "id": id }, { "type": "public-key", "id": id, "transports": ["usb"] },
        ],
        "userVerification": "required",
    } });
    assert_eq!(serde_json::from_str::<Value>(&options).unwrap(), expected);
}

#[test]
fn passkeys_belong_to_a_name_that_browsers_trust() {
    for (public_url, listen, expected) in [
        (Some("https://training.example.org"), "127.0.0.1:8080", Some("https://training.example.org")),
        (Some("https://training.example.org:8443/stylet"), "0.0.0.0:80", Some("https://training.example.org:8443")),
        (Some("http://localhost:9000"), "127.0.0.1:8080", Some("http://localhost:9000")),
        (None, "127.0.0.1:8080", Some("http://localhost:8080")),
        (None, "[::1]:8080", Some("http://localhost:8080")),
        (None, "10.0.0.1:8080", None),
        (Some("http://training.example.org"), "127.0.0.1:8080", None),
        (Some("https://10.0.0.1"), "127.0.0.1:8080", None),
        (Some("training.example.org"), "127.0.0.1:8080", None),
    ] {
        let found = party_of(public_url, listen);
        assert_eq!(found.as_ref().map(RelyingParty::origin), expected, "{public_url:?} {listen}");
    }
}

#[test]
fn on_trial_any_port_of_this_machine_is_ours_and_nothing_else() {
    let trial = party_of(None, "127.0.0.1:0").unwrap();
    for origin in ["http://localhost", "http://localhost:1", "http://localhost:65535"] {
        assert!(trial.is_own(origin), "{origin}");
    }
    for origin in [
        "https://localhost:1",
        "http://localhost:80",
        "http://localhost:65536",
        "http://localhost:1/",
        "http://localhost:01",
        "http://user@localhost:1",
        "http://localhost.example.org",
        "http://127.0.0.1:1",
        "",
    ] {
        assert!(!trial.is_own(origin), "{origin}");
    }
    let named = party_of(Some("http://localhost:9000"), "127.0.0.1:9000").unwrap();
    assert!(named.is_own("http://localhost:9000") && !named.is_own("http://localhost:9001"));
}
