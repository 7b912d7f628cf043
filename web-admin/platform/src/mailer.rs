//! Sends mail: by SMTP if a server is configured, else as files in a folder, for evaluation and
//! tests.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use anyhow::Context;
use lettre::message::{Mailbox, Message};
use lettre::{AsyncSmtpTransport, AsyncTransport, Tokio1Executor};
use model::Moment;
use model::ids::LetterId;
use model::people::email::email_in_ascii;

use crate::config::{Config, MailTo};

/// A mail ready to be sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Letter {
    /// Id; also its file name and part of its `Message-ID`.
    pub id: LetterId,
    /// Name of the recipient.
    pub name: String,
    /// Address of the recipient.
    pub email: String,
    /// Subject.
    pub subject: String,
    /// Body, plain text.
    pub body: String,
}

/// Sends mails.
#[derive(Clone, Debug)]
pub struct Mailer {
    from: Mailbox,
    way: MailerWay,
}

#[derive(Clone, Debug)]
enum MailerWay {
    Folder(PathBuf),
    Smtp(AsyncSmtpTransport<Tokio1Executor>),
}

impl Mailer {
    /// Creates a mailer from the configuration.
    ///
    /// # Errors
    /// Fails if the sender is not a valid address, or the server's URL is invalid.
    pub fn new(config: &Config) -> anyhow::Result<Self> {
        let from = config.mail_from.parse().with_context(|| format!("--mail-from: \"{}\"", config.mail_from))?;
        let way = match &config.mail {
            MailTo::Folder(folder) => MailerWay::Folder(folder.clone()),
            MailTo::Smtp(url) => {
                // The error must not repeat the URL, which may contain a password.
                let transport = AsyncSmtpTransport::<Tokio1Executor>::from_url(url).context("--mail")?;
                MailerWay::Smtp(transport.timeout(Some(Duration::from_secs(30))).build())
            }
        };
        Ok(Self { from, way })
    }

    /// Deletes mails from the mail folder, if there is one, because they name their recipients.
    /// Mails sent by SMTP cannot be recalled.
    ///
    /// # Errors
    /// Fails if a file exists and cannot be deleted.
    pub async fn forget(&self, letters: &[LetterId]) -> std::io::Result<()> {
        let MailerWay::Folder(folder) = &self.way else { return Ok(()) };
        for letter in letters {
            match tokio::fs::remove_file(file_of(folder, *letter)).await {
                Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        Ok(())
    }

    /// Sends a mail.
    ///
    /// # Errors
    /// Fails if the server rejects it, or the file cannot be written.
    pub async fn send(&self, letter: Letter, now: Moment) -> anyhow::Result<()> {
        let since = now.duration_since(Moment::from_micros(0));
        let message = Message::builder()
            .from(self.from.clone())
            .to(Mailbox::new(
                Some(letter.name),
                email_in_ascii(&letter.email).parse().context("invalid email address")?,
            ))
            .subject(letter.subject)
            .date(SystemTime::UNIX_EPOCH + since)
            .message_id(Some(format!("<{}@{}>", letter.id, self.from.email.domain())))
            .header(lettre::message::header::ContentType::TEXT_PLAIN)
            .body(letter.body)?;
        match &self.way {
            MailerWay::Smtp(transport) => {
                transport.send(message).await.map(drop).context("the mail server rejected the email")
            }
            MailerWay::Folder(folder) => {
                tokio::fs::create_dir_all(folder).await.context("cannot create the mail folder")?;
                tokio::fs::write(file_of(folder, letter.id), message.formatted())
                    .await
                    .context("cannot write the email")
            }
        }
    }
}

fn file_of(folder: &Path, letter: LetterId) -> PathBuf {
    folder.join(format!("{letter}.eml"))
}
