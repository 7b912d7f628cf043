//! Badges and status lists as another implementation makes them: `tests/data/badge/make.py` has
//! written the credentials, their canonical N-Quads and their signatures with PyLD and
//! openbadgeslib. A difference of one byte would make other programs reject every badge.

use ed25519_dalek::SigningKey;
use serde_json::{Value, json};

use super::proof::option_quads;
use super::*;
use crate::training::certificate::public_key;
use crate::training::random_numbers::RandomNumbers;

/// Names that are hard to write in JSON, N-Quads and XML; and what identifies the badge.
const INPUT: &str = include_str!("../../../../../tests/data/badge/input.json");
const BADGE: &str = include_str!("../../../../../tests/data/badge/badge.json");
const LIST: &str = include_str!("../../../../../tests/data/badge/list.json");

fn key() -> SigningKey {
    SigningKey::from_bytes(&[7; 32])
}

fn issuer() -> IssuerAddress {
    IssuerAddress::of("https://stylet.example:8443").expect("an address")
}

fn sample() -> Badge {
    let input: Value = serde_json::from_str(INPUT).expect("JSON");
    let statement = serde_json::from_value(input["statement"].clone()).expect("a statement");
    let place = StatusPlace::of(2, 131_071).expect("a place");
    let issued = IssuedBadge { id: BadgeId::from_u128(0x17), person: PersonId::from_u128(0xada), place };
    Badge::of(&statement, &issuer(), issued).expect("a badge")
}

fn list(issuer: &IssuerAddress) -> StatusList<'_> {
    let at = |index| StatusPlace::of(2, index).expect("a place");
    StatusList {
        issuer,
        list: 2,
        revoked: vec![at(0), at(17), at(131_071)],
        valid_from: "2026-05-20T09:00:00Z".to_owned(),
        valid_until: "2026-05-21T09:00:00Z".to_owned(),
    }
}

fn sign(badge: &Badge) -> Value {
    let key = key();
    let signer = BadgeSigner { issuer: &badge.issuer, key: &key, created: "2026-05-20T09:00:00Z" };
    badge.sign(signer).expect("signed")
}

#[test]
fn a_badge_equals_one_made_by_openbadgeslib() {
    let golden: Value = serde_json::from_str(BADGE).expect("JSON");
    assert_eq!(sample().quads().expect("addresses"), include_str!("../../../../../tests/data/badge/badge.nq"));
    let method = issuer().key_id(&key().verifying_key());
    let options = option_quads("2026-05-20T09:00:00Z", &method);
    assert_eq!(options, include_str!("../../../../../tests/data/badge/options.nq"));
    assert_eq!(sign(&sample()), golden);
    assert_eq!(check_badge(BADGE.as_bytes(), &public_key(&key())).expect("genuine"), sample());
}

#[test]
fn a_list_equals_one_made_by_openbadgeslib() {
    let golden: Value = serde_json::from_str(LIST).expect("JSON");
    let (issuer, key) = (issuer(), key());
    let signer = BadgeSigner { issuer: &issuer, key: &key, created: "2026-05-20T09:00:00Z" };
    let signed = list(&issuer).sign(signer).expect("signed");
    // Packers differ in their output, so the list is compared as bits, and the rest by its quads.
    let encoded = golden["credentialSubject"]["encodedList"].as_str().expect("a text");
    let quads = list(&issuer).quads(encoded).expect("addresses");
    assert_eq!(quads, include_str!("../../../../../tests/data/badge/list.nq"));
    assert_eq!(unpack(&signed), unpack(&golden));
    let (mut ours, mut theirs) = (signed, golden);
    for one in [&mut ours, &mut theirs] {
        one["credentialSubject"]["encodedList"] = Value::Null;
        one["proof"]["proofValue"] = Value::Null;
    }
    assert_eq!(ours, theirs);
    let elsewhere = StatusList { list: 1, ..list(&issuer) };
    assert!(elsewhere.sign(signer).is_err(), "places of another list");
}

fn unpack(list: &Value) -> Vec<u8> {
    use std::io::Read;
    let encoded = list["credentialSubject"]["encodedList"].as_str().and_then(|text| text.strip_prefix('u'));
    let packed = data_encoding::BASE64URL_NOPAD.decode(encoded.expect("base64url").as_bytes()).expect("base64url");
    let mut bits = Vec::new();
    flate2::read::GzDecoder::new(&packed[..]).read_to_end(&mut bits).expect("gzip");
    assert_eq!(bits.len(), 16 * 1024);
    bits
}

#[test]
fn every_changed_byte_of_a_badge_is_rejected() {
    let (file, key) = (sign(&sample()).to_string().into_bytes(), public_key(&key()));
    check_badge(&file, &key).expect("genuine");
    for place in 0..file.len() {
        let mut changed = file.clone();
        // Another letter, or the same one in the other case.
        changed[place] ^= if place % 2 == 0 { 0x01 } else { 0x20 };
        assert!(check_badge(&changed, &key).is_err(), "byte {place}: {}", String::from_utf8_lossy(&changed));
    }
}

#[test]
fn a_badge_with_other_members_is_rejected() {
    let (signed, key) = (sign(&sample()), public_key(&key()));
    let rejected = |changed: &Value| check_badge(changed.to_string().as_bytes(), &key).is_err();
    assert!(!rejected(&signed));
    for pointer in
        ["", "/issuer", "/credentialSubject", "/credentialSubject/achievement", "/credentialStatus", "/proof"]
    {
        let mut more = signed.clone();
        more.pointer_mut(pointer).expect("a member")["more"] = json!("x");
        assert!(rejected(&more), "{pointer} with another member");
        let members = signed.pointer(pointer).and_then(Value::as_object).expect("an object");
        for name in members.keys() {
            let mut less = signed.clone();
            less.pointer_mut(pointer).and_then(Value::as_object_mut).expect("an object").remove(name);
            assert!(rejected(&less), "{pointer} without {name}");
        }
    }
}

#[test]
fn only_the_issuer_signs_badges_in_its_name() {
    let key = key();
    let foreign = SigningKey::from_bytes(&[8; 32]);
    let signed = sign(&sample()).to_string();
    assert!(check_badge(signed.as_bytes(), &public_key(&foreign)).is_err(), "another key");
    let stolen = IssuerAddress { did: "did:web:other.example".to_owned(), ..issuer() };
    let badge = Badge { issuer: stolen, ..sample() };
    let signer = BadgeSigner { issuer: &badge.issuer, key: &key, created: "2026-05-20T09:00:00Z" };
    let stolen = badge.sign(signer).expect("signed").to_string();
    let why = check_badge(stolen.as_bytes(), &public_key(&key)).expect_err("another's name").to_string();
    assert!(why.contains("did:web:other.example"), "{why}");
    let nameless =
        Badge { issuer: IssuerAddress { did: "https://stylet.example:8443".to_owned(), ..issuer() }, ..sample() };
    let nameless = sign(&nameless).to_string();
    assert!(check_badge(nameless.as_bytes(), &public_key(&key)).is_err(), "an issuer without a did");
}

#[test]
fn a_picture_carries_the_badge_unchanged() {
    let signed = sign(&sample());
    let picture = format!("<svg xmlns=\"http://www.w3.org/2000/svg\">{}<g/></svg>", write_baked(&signed));
    assert!(signed.to_string().contains("]]>"), "the sample must contain the end of such a section");
    assert_eq!(picture.matches("]]>").count(), 1, "{picture}");
    assert!(is_badge(picture.as_bytes()) && is_badge(BADGE.as_bytes()) && !is_badge(b"{}") && !is_badge(b"\xff"));
    assert_eq!(check_badge(picture.as_bytes(), &public_key(&key())).expect("genuine"), sample());
    let cut = picture.split(BAKED_CLOSING).next().expect("a start");
    assert!(check_badge(cut.as_bytes(), &public_key(&key())).is_err());
}

#[test]
fn places_are_counted_through_all_lists() {
    for (number, list, index) in [(0, 0, 0), (131_071, 0, 131_071), (131_072, 1, 0), (262_145, 2, 1)] {
        let place = StatusPlace::numbered(number);
        assert_eq!((place.list(), place.index(), place.number()), (list, index, number));
        assert_eq!(StatusPlace::of(list, index), Some(place));
    }
    assert_eq!(StatusPlace::of(0, 131_072), None);
    assert_eq!(StatusPlace::of(u64::MAX, 0), None);
}

#[test]
fn control_characters_never_reach_a_badge() {
    let sample: Value = serde_json::from_str(INPUT).expect("JSON");
    let mut statement: Statement = serde_json::from_value(sample["statement"].clone()).expect("a statement");
    let controls: String = (0..0x20_u8).chain(0x7f..0xa0).map(char::from).chain(['\u{fffe}', '\u{ffff}']).collect();
    for name in [&mut statement.school, &mut statement.course, &mut statement.exercises[0].0] {
        name.push_str(&controls);
    }
    let place = StatusPlace::numbered(0);
    let issued = IssuedBadge { id: BadgeId::nil(), person: PersonId::nil(), place };
    let badge = Badge::of(&statement, &issuer(), issued).expect("a badge");
    let Achievement { name, description, .. } = &badge.achievement;
    for text in [&badge.school, name, description] {
        assert!(!text.contains(|c: char| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}')), "{text:?}");
    }
    let written = sign(&badge).to_string();
    check_badge(written.as_bytes(), &public_key(&key())).expect("genuine");
}

/// Characters of random names: those that JSON, N-Quads or XML escape, that programs have split lines at, and of other scripts.
const HOSTILE: &str = "aZ09 \"\\'<>&{}[]|^`%#?\u{7f}\u{80}\u{85}\u{a0}\u{1}\t\n\r\u{2028}\u{2029}\u{feff}\u{fffd}\u{fffe}üßéе́שع漢𝔘🩺👩🏽\u{200d}⚕\u{10ffff}]]>\\u0041";

impl RandomNumbers {
    fn text(&mut self) -> String {
        let known: Vec<char> = HOSTILE.chars().collect();
        (0..=self.below(30)).map(|_| known[self.below(known.len())]).collect()
    }

    fn badge(&mut self, issuer: &IssuerAddress) -> Badge {
        let exercises =
            (0..=self.below(4)).map(|day| (self.text(), format!("2026-05-0{}T09:30:00Z", day + 1))).collect();
        let statement = Statement {
            format: Statement::FORMAT,
            school: self.text(),
            trainee: self.text(),
            registrar_id: None,
            curriculum_id: "lower-back-basics".to_owned(),
            course: self.text(),
            curriculum_sha256: format!("{:064x}", self.next()),
            rule: self.text(),
            attempts: (self.below(2) == 0).then(|| self.text()),
            exercises,
            issued_at: "2026-05-20T09:00:00Z".to_owned(),
            scope: self.text(),
        };
        let [id, person] = [self.next(), self.next()].map(u128::from);
        let place = StatusPlace::numbered(i64::try_from(self.below(1_000_000)).expect("a place"));
        let issued = IssuedBadge { id: BadgeId::from_u128(id), person: PersonId::from_u128(person), place };
        Badge::of(&statement, issuer, issued).expect("a badge")
    }
}

/// Writes badges and their status lists for other programs, if they ask for them: `tests/counterparts/badges.py`.
#[test]
fn badges_with_hostile_names_are_genuine() {
    let (issuer, key) = (issuer(), key());
    let kept = std::env::var_os("STYLET_KEEP_BADGES");
    let mut numbers = RandomNumbers(1);
    let badges: Vec<Badge> = (0..if kept.is_some() { 1000 } else { 50 }).map(|_| numbers.badge(&issuer)).collect();
    let signed: Vec<String> = badges.iter().map(|badge| sign(badge).to_string()).collect();
    for (badge, signed) in badges.iter().zip(&signed) {
        assert_eq!(check_badge(signed.as_bytes(), &public_key(&key)).expect("genuine"), *badge);
    }
    let Some(file) = kept else { return };
    let mut documents = json!({ &issuer.did: issuer.did_document(&key) });
    let revoked: Vec<StatusPlace> = badges.iter().map(|badge| badge.place).step_by(7).collect();
    for list in 0..8 {
        let revoked = revoked.iter().copied().filter(|place| place.list() == list).collect();
        let (from, until) = ("2026-01-01T00:00:00Z".to_owned(), "2999-01-01T00:00:00Z".to_owned());
        let published = StatusList { issuer: &issuer, list, revoked, valid_from: from, valid_until: until };
        let signer = BadgeSigner { issuer: &issuer, key: &key, created: "2026-05-20T09:00:00Z" };
        documents[issuer.status_list(list)] = published.sign(signer).expect("signed");
    }
    let badges = badges.iter().zip(signed);
    let badges = badges.map(|(badge, text)| json!({ "text": text, "revoked": revoked.contains(&badge.place) }));
    let all = json!({ "documents": documents, "badges": badges.collect::<Vec<_>>() });
    std::fs::write(file, all.to_string()).expect("a file");
}
