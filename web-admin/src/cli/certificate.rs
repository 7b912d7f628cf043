//! `web-admin certificate`: prints the public key, and checks a certificate without the service.

use std::path::PathBuf;

use acts::training::certificates;
use clap::{Args, Subcommand};
use model::training::certificate::{Statement, check_certificate};

use super::{CommandFailure, StorageArgs, say_line};

/// `web-admin certificate …`
#[derive(Debug, Subcommand)]
pub enum CertificateCommand {
    /// Prints the public key of this service, for the school to publish
    Key(StorageArgs),
    /// Checks a certificate and prints every signed field; needs neither the service nor its data
    Verify(CertificateArgs),
}

/// Options of `web-admin certificate verify`.
#[derive(Debug, Args)]
pub struct CertificateArgs {
    /// The certificate: the saved page, or the JSON in it
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
    match check_certificate(&bytes, key) {
        Ok(statement) => {
            lines_of_certificate(&statement).iter().for_each(say_line);
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

/// Replaces control characters: a name may contain anything, also escape sequences of a terminal.
fn on_one_line(text: &str) -> String {
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
