//! Open Badges 3.0: the statement of a certificate as a Verifiable Credential 2.0.
//!
//! Every badge is a graph of the same shape with one blank node. Its canonical form is therefore
//! written directly, without a library of JSON-LD, and the contexts are never read.
//! `docs/certificates.md` describes badges for other programs.

mod identity;
mod proof;
mod quads;
mod status;
#[cfg(test)]
mod tests;

use anyhow::{Context, ensure};
use data_encoding::HEXLOWER_PERMISSIVE;
use ed25519_dalek::VerifyingKey;
pub use identity::{IssuerAddress, multikey};
pub use proof::BadgeSigner;
use proof::{DATE_TIME, check_proof};
use quads::{BLANK, Quads, TypedValue, check_address};
use serde_json::{Value, json};
pub use status::{StatusList, StatusPlace};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::ids::{BadgeId, PersonId};
use crate::training::certificate::Statement;

/// The first context of every credential.
const CREDENTIALS_CONTEXT: &str = "https://www.w3.org/ns/credentials/v2";
/// The context of Open Badges.
const BADGES_CONTEXT: &str = "https://purl.imsglobal.org/spec/ob/v3p0/context-3.0.3.json";
/// Prefix of the vocabulary of credentials.
const CREDENTIALS: &str = "https://www.w3.org/2018/credentials#";
/// Prefix of the vocabulary of Open Badges.
const BADGES: &str = "https://purl.imsglobal.org/spec/vc/ob/vocab.html#";
/// Prefix of the vocabulary of status lists.
const STATUS: &str = "https://www.w3.org/ns/credentials/status#";
/// Names and descriptions.
const NAME: &str = "https://schema.org/name";
/// Start of a badge in a picture.
pub const BAKED_OPENING: &str = "<openbadges:credential><![CDATA[";
/// End of a badge in a picture.
pub const BAKED_CLOSING: &str = "]]></openbadges:credential>";

/// A badge without its proof.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Badge {
    /// Id of the badge.
    pub id: BadgeId,
    /// The service that issued it.
    pub issuer: IssuerAddress,
    /// Name of the school.
    pub school: String,
    /// The person who mastered the course.
    pub person: PersonId,
    /// The mastered course.
    pub achievement: Achievement,
    /// Time from which the course is mastered, RFC 3339 in whole seconds.
    pub mastered_at: String,
    /// Place in the status lists.
    pub place: StatusPlace,
}

/// A mastered course, as a badge describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Achievement {
    /// Address of the revision.
    pub id: String,
    /// Title of the course.
    pub name: String,
    /// Its exercises.
    pub description: String,
    /// Rule of mastery, attempts that count, and limits of the statement.
    pub narrative: String,
}

impl Achievement {
    /// Returns the achievement that a certificate states.
    fn of(statement: &Statement, issuer: &IssuerAddress) -> Self {
        let Statement { curriculum_id, curriculum_sha256, rule, scope, .. } = statement;
        let exercises: Vec<&str> = statement.exercises.iter().map(|(title, _)| title.as_str()).collect();
        let attempts = statement.attempts.as_deref().unwrap_or("every scored attempt");
        Self {
            id: format!("{}/curricula/{curriculum_id}/revisions/{curriculum_sha256}", issuer.url),
            name: plain_text(&statement.course),
            description: plain_text(&format!("All exercises mastered in the simulator: {}.", exercises.join("; "))),
            narrative: plain_text(&format!("An exercise is {rule}. Attempts counted: {attempts}. {scope}")),
        }
    }
}

/// Returns a time in RFC 3339, in whole seconds.
///
/// # Errors
/// If its year has more than four digits.
pub fn write_time(at: OffsetDateTime) -> anyhow::Result<String> {
    Ok(at.replace_nanosecond(0)?.format(&Rfc3339)?)
}

/// Replaces control characters and noncharacters by spaces: programs disagree on their canonical
/// form.
fn plain_text(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c }).collect()
}

/// What a badge adds to a certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IssuedBadge {
    /// Id of the badge.
    pub id: BadgeId,
    /// The person who mastered the course.
    pub person: PersonId,
    /// Place in the status lists.
    pub place: StatusPlace,
}

impl Badge {
    /// Returns the badge for the statement of a certificate.
    ///
    /// # Errors
    /// If the statement has no exercises, or one of its times is not in RFC 3339.
    pub fn of(statement: &Statement, issuer: &IssuerAddress, issued: IssuedBadge) -> anyhow::Result<Self> {
        let times = statement.exercises.iter().map(|(_, at)| OffsetDateTime::parse(at, &Rfc3339));
        let times: Vec<OffsetDateTime> = times.collect::<Result<_, _>>().context("not a time")?;
        let last = times.into_iter().max().context("a course without exercises")?;
        Ok(Self {
            id: issued.id,
            issuer: issuer.clone(),
            school: plain_text(&statement.school),
            person: issued.person,
            achievement: Achievement::of(statement, issuer),
            mastered_at: write_time(last)?,
            place: issued.place,
        })
    }

    /// Returns the badge with its proof.
    ///
    /// # Errors
    /// If one of its addresses is not an address.
    pub fn sign(&self, signer: BadgeSigner<'_>) -> anyhow::Result<Value> {
        Ok(signer.add_proof(self.credential(), &self.quads()?))
    }

    /// Returns the badge as a credential.
    fn credential(&self) -> Value {
        let Achievement { id, name, description, narrative } = &self.achievement;
        let list = self.issuer.status_list(self.place.list());
        json!({
            "@context": [CREDENTIALS_CONTEXT, BADGES_CONTEXT],
            "id": format!("urn:uuid:{}", self.id),
            "type": ["VerifiableCredential", "OpenBadgeCredential"],
            "name": name,
            "issuer": {"id": self.issuer.did, "type": ["Profile"], "name": self.school, "url": self.issuer.url},
            "validFrom": self.mastered_at,
            "credentialSubject": {
                "id": format!("urn:uuid:{}", self.person),
                "type": ["AchievementSubject"],
                "achievement": {
                    "id": id,
                    "type": ["Achievement"],
                    "achievementType": "Course",
                    "name": name,
                    "description": description,
                    "criteria": {"narrative": narrative},
                },
            },
            "credentialStatus": {
                "id": format!("{list}#{}", self.place.index()),
                "type": "BitstringStatusListEntry",
                "statusPurpose": "revocation",
                "statusListIndex": self.place.index().to_string(),
                "statusListCredential": list,
            },
        })
    }

    /// Returns the canonical N-Quads of the badge.
    fn quads(&self) -> anyhow::Result<String> {
        let Achievement { id: course, name, description, narrative } = &self.achievement;
        let list = self.issuer.status_list(self.place.list());
        let (badge, subject) = (format!("urn:uuid:{}", self.id), format!("urn:uuid:{}", self.person));
        let status = format!("{list}#{}", self.place.index());
        let [credentials, badges, statuses] =
            [CREDENTIALS, BADGES, STATUS].map(|prefix| move |name: &str| format!("{prefix}{name}"));
        for address in [&self.issuer.did, &self.issuer.url, course, &list] {
            check_address(address)?;
        }
        let mut quads = Quads::default();
        quads.add_type(&badge, &credentials("VerifiableCredential"));
        quads.add_type(&badge, &badges("OpenBadgeCredential"));
        quads.add_text(&badge, NAME, name);
        quads.add_node(&badge, &credentials("issuer"), &self.issuer.did);
        let time = TypedValue { value: &self.mastered_at, datatype: DATE_TIME };
        quads.add_typed(&badge, &credentials("validFrom"), time);
        quads.add_node(&badge, &credentials("credentialSubject"), &subject);
        quads.add_node(&badge, &credentials("credentialStatus"), &status);

        quads.add_type(&self.issuer.did, &badges("Profile"));
        quads.add_text(&self.issuer.did, NAME, &self.school);
        let url = TypedValue { value: &self.issuer.url, datatype: "https://www.w3.org/2001/XMLSchema#anyURI" };
        quads.add_typed(&self.issuer.did, "https://schema.org/url", url);

        quads.add_type(&subject, &badges("AchievementSubject"));
        quads.add_node(&subject, &badges("achievement"), course);
        quads.add_type(course, &badges("Achievement"));
        quads.add_text(course, &badges("achievementType"), "Course");
        quads.add_text(course, NAME, name);
        quads.add_text(course, "https://schema.org/description", description);
        quads.add_node(course, &badges("Criteria"), BLANK);
        quads.add_text(BLANK, &badges("narrative"), narrative);

        quads.add_type(&status, &statuses("BitstringStatusListEntry"));
        quads.add_text(&status, &statuses("statusPurpose"), "revocation");
        quads.add_text(&status, &statuses("statusListIndex"), &self.place.index().to_string());
        quads.add_node(&status, &statuses("statusListCredential"), &list);
        Ok(quads.canonical())
    }

    /// Returns the badge of a credential; `None` if a member is missing.
    fn of_credential(credential: &Value) -> Option<Self> {
        let text = |pointer: &str| credential.pointer(pointer)?.as_str().map(str::to_owned);
        let id = |pointer: &str| text(pointer)?.strip_prefix("urn:uuid:").map(str::to_owned);
        let achievement = |member: &str| text(&format!("/credentialSubject/achievement/{member}"));
        let issuer = IssuerAddress { url: text("/issuer/url")?, did: text("/issuer/id")? };
        let (_, list) = credential.pointer("/credentialStatus/statusListCredential")?.as_str()?.rsplit_once('/')?;
        let index = text("/credentialStatus/statusListIndex")?;
        Some(Self {
            id: id("/id")?.parse().ok()?,
            issuer,
            school: text("/issuer/name")?,
            person: id("/credentialSubject/id")?.parse().ok()?,
            achievement: Achievement {
                id: achievement("id")?,
                name: achievement("name")?,
                description: achievement("description")?,
                narrative: achievement("criteria/narrative")?,
            },
            mastered_at: text("/validFrom")?,
            place: StatusPlace::of(list.parse().ok()?, index.parse().ok()?)?,
        })
    }
}

/// Returns the JSON of a badge for a picture: a name must not end the section that contains it.
#[must_use]
pub fn write_baked(badge: &Value) -> String {
    format!("{BAKED_OPENING}{}{BAKED_CLOSING}", badge.to_string().replace("]]>", "]]\\u003e"))
}

/// Returns whether a file is meant to be a badge, as JSON or in a picture.
#[must_use]
pub fn is_badge(file: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(file) else { return false };
    text.contains(BAKED_OPENING) || (text.starts_with('{') && text.contains(BADGES_CONTEXT))
}

/// Verifies a badge of our own shape, as JSON or in a picture, with the public key published by the
/// school. It does not check whether the badge was revoked, which only the service knows.
///
/// # Errors
/// If it is not such a badge, was signed with another key or in another's name, or was modified.
pub fn check_badge(file: &[u8], published_key: &str) -> anyhow::Result<Badge> {
    let text = std::str::from_utf8(file).context("not a badge")?;
    let json = match text.split_once(BAKED_OPENING) {
        Some((_, inside)) => inside.split_once(BAKED_CLOSING).context("not a badge: the picture is truncated")?.0,
        None => text,
    };
    let mut signed: Value = serde_json::from_str(json).context("not a badge")?;
    let badge = Badge::of_credential(&signed).context("not a badge of Stylet: a member is missing")?;
    let key = parse_key(published_key)?;
    let issuer = IssuerAddress::of(&badge.issuer.url)?;
    ensure!(issuer == badge.issuer, "{} does not issue badges as {}", badge.issuer.url, badge.issuer.did);
    let proof =
        signed.as_object_mut().and_then(|members| members.remove("proof")).context("a badge without a proof")?;
    ensure!(signed == badge.credential(), "not a badge of Stylet: it has other members");
    check_proof(&proof, &badge.quads()?, &issuer.key_id(&key), &key)?;
    Ok(badge)
}

fn parse_key(hexadecimal: &str) -> anyhow::Result<VerifyingKey> {
    let bytes = HEXLOWER_PERMISSIVE.decode(hexadecimal.trim().as_bytes())?;
    let bytes: [u8; 32] = bytes.try_into().ok().context("a public key has 64 hexadecimal digits")?;
    VerifyingKey::from_bytes(&bytes).context("not a public key")
}
