//! `web-admin certificate`: prints the public key, and checks a certificate or a badge without the
//! service.

use std::path::PathBuf;

use acts::training::certificates;
use clap::{Args, Subcommand};
use model::training::badge::{Achievement, Badge, check_badge, is_badge};
use model::training::certificate::{Statement, check_certificate};

use super::{CommandFailure, StorageArgs, say_line};

/// `web-admin certificate …`
#[derive(Debug, Subcommand)]
pub enum CertificateCommand {
    /// Prints the public key of this service, for the school to publish
    Key(StorageArgs),
    /// Checks a certificate or a badge and prints every signed field; needs neither the service nor
    /// its data
    Verify(CertificateArgs),
}

/// Options of `web-admin certificate verify`.
#[derive(Debug, Args)]
pub struct CertificateArgs {
    /// The certificate: the saved page, or the JSON in it; or a badge: JSON or SVG
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The public key that the school has published, 64 hexadecimal digits
    #[arg(long, value_name = "HEX")]
    key: String,
}

pub(super) fn run_certificate(command: &CertificateCommand) -> Result<(), CommandFailure> {
    match command {
        CertificateCommand::Key(storage) => {
            say_line(certificates::public_key(&storage.config()?.keys_dir)?);
            Ok(())
        }
        CertificateCommand::Verify(args) => verify_certificate(args),
    }
}

fn verify_certificate(CertificateArgs { file, key }: &CertificateArgs) -> Result<(), CommandFailure> {
    let bytes = std::fs::read(file).map_err(|error| CommandFailure::Usage(format!("{}: {error}", file.display())))?;
    let checked = match is_badge(&bytes) {
        true => check_badge(&bytes, key).map(|badge| lines_of_badge(&badge)),
        false => check_certificate(&bytes, key).map(|statement| lines_of_certificate(&statement)),
    };
    match checked {
        Ok(lines) => {
            lines.iter().for_each(say_line);
            Ok(())
        }
        Err(why) => {
            say_line(format_args!("not genuine: {}: {why:#}", file.display()));
            Err(CommandFailure::Found)
        }
    }
}

/// Formats every signed field, one per line.
fn lines_of_certificate(statement: &Statement) -> Vec<String> {
    // Destructured without `..`, so that a new field of the statement must be added here.
    let Statement {
        format: _,
        school,
        trainee,
        registrar_id,
        curriculum_id,
        course,
        curriculum_sha256,
        rule,
        attempts,
        exercises,
        issued_at,
        scope,
    } = statement;
    let number = registrar_id.as_ref().map_or_else(String::new, |number| format!(" ({number})"));
    let mut lines = vec![
        format!("genuine: {trainee}{number} mastered “{course}” at {school}, issued {issued_at}"),
        format!("  course    {curriculum_id}, document with SHA-256 {curriculum_sha256}"),
        format!("  rule      an exercise is {rule}"),
    ];
    lines.extend(attempts.iter().map(|attempts| format!("  counting  {attempts}")));
    lines.extend(exercises.iter().map(|(exercise, on)| format!("  mastered  {exercise}, {on}")));
    lines.push(format!("  scope     {scope}"));
    lines.iter().map(|line| on_one_line(line)).collect()
}

/// Formats every signed field of a badge, one per line.
fn lines_of_badge(badge: &Badge) -> Vec<String> {
    // Destructured without `..`, so that a new field of the badge must be added here.
    let Badge { id, issuer, school, person, achievement, mastered_at, place } = badge;
    let Achievement { id: course, name, description, narrative } = achievement;
    let lines = [
        format!("genuine: badge {id} for person {person}, who mastered “{name}” at {school} on {mastered_at}"),
        format!("  issuer    {}, {}", issuer.did, issuer.url),
        format!("  course    {course}"),
        format!("  exercises {description}"),
        format!("  criteria  {narrative}"),
        format!("  revoked?  see index {} of {}", place.index(), issuer.status_list(place.list())),
    ];
    lines.iter().map(|line| on_one_line(line)).collect()
}

/// Replaces control characters: a name may contain anything, also escape sequences of a terminal.
pub(super) fn on_one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '�' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    //! Fails when a signed field is not printed, or a name starts a line of its own.

    use super::*;

    fn sample() -> Statement {
        let file = include_str!("../../../tests/data/certificate/statement.json");
        serde_json::from_str(file).expect("a statement")
    }

    #[test]
    fn every_field_of_a_badge_is_printed() {
        let file = include_bytes!("../../../tests/data/badge/badge.json");
        let key = "ea4a6c63e29c520abef5507b132ec5f9954776aebebe7b92421eea691446d22c";
        let all = lines_of_badge(&check_badge(file, key).expect("genuine")).join("\n");
        let signed: serde_json::Value = serde_json::from_slice(file).expect("JSON");
        for pointer in [
            "/name",
            "/issuer/id",
            "/issuer/name",
            "/issuer/url",
            "/validFrom",
            "/credentialSubject/achievement/id",
            "/credentialSubject/achievement/description",
            "/credentialSubject/achievement/criteria/narrative",
            "/credentialStatus/statusListIndex",
            "/credentialStatus/statusListCredential",
        ] {
            let value = signed.pointer(pointer).and_then(serde_json::Value::as_str).expect("a text");
            assert!(all.contains(value), "{pointer} is not printed:\n{all}");
        }
    }

    #[test]
    fn everything_signed_is_printed_on_lines_of_its_own() {
        let exercises = vec![("Feel\nthe layers".to_owned(), "2026-05-01T09:00:00Z".to_owned())];
        let trainee = "Ada\ngenuine: Bob\u{1b}[2J".to_owned();
        let statement = Statement { trainee, exercises, ..sample() };
        let lines = lines_of_certificate(&statement);
        assert!(lines.iter().all(|line| !line.contains(char::is_control)), "{lines:?}");
        assert_eq!(lines.iter().filter(|line| line.starts_with("genuine")).count(), 1);
        let all = lines.join("\n");
        let signed = serde_json::to_value(&statement).expect("JSON");
        for (name, value) in signed.as_object().expect("a table").iter().filter(|(_, value)| value.is_string()) {
            assert!(all.contains(&on_one_line(value.as_str().unwrap_or_default())), "{name} is not printed:\n{all}");
        }
        assert!(all.contains("Feel�the layers, 2026-05-01T09:00:00Z"), "{all}");
    }
}
