//! `web-admin certificate`: the public key, and checking a certificate without the service.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::{Failure, Storage, say};
use crate::certificates;

/// `web-admin certificate …`
#[derive(Debug, Subcommand)]
pub enum CertificateCommand {
    /// Prints the public key of this service, for the school to publish
    Key(Storage),
    /// Checks a certificate; needs neither the service nor its data
    Verify(VerifyArgs),
}

/// What to check against what.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// The certificate
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The public key that the school has published, 64 hexadecimal digits
    #[arg(long, value_name = "HEX")]
    key: String,
}

pub(super) fn run(command: &CertificateCommand) -> Result<(), Failure> {
    match command {
        CertificateCommand::Key(storage) => {
            say(certificates::public_key(&storage.config()?.data_dir)?);
            Ok(())
        }
        CertificateCommand::Verify(args) => verify(args),
    }
}

fn verify(VerifyArgs { file, key }: &VerifyArgs) -> Result<(), Failure> {
    let bytes = std::fs::read(file).map_err(|error| Failure::Usage(format!("{}: {error}", file.display())))?;
    match certificates::check(&bytes, key) {
        Ok(statement) => {
            say(format_args!(
                "genuine: {} mastered “{}” at {}, issued {}",
                statement.trainee, statement.course, statement.school, statement.issued_at
            ));
            Ok(())
        }
        Err(why) => {
            say(format_args!("not genuine: {}: {why:#}", file.display()));
            Err(Failure::Found)
        }
    }
}
