//! `web-admin user`: adds people and manages their access.

use acts::auth::tokens::{LONGEST_DAYS, TokenRequest};
use acts::auth::{passwords, second_factor};
use acts::people::admin_commands;
use acts::people::admin_commands::{AddedAccount, RegisteredPerson};
use clap::{Args, Subcommand};
use model::auth::password_refused::PasswordRefused;
use model::people::roster::is_name;
use model::single_line_text::on_one_line;
use model::{Moment, PersonKey, Role};
use platform::secret;
use store::audit::Actor;
use store::operations::schools;
use store::people::{self, Person};

use super::{CommandFailure, StorageArgs, say_line};
use crate::AppState;

/// `web-admin user …`
#[derive(Debug, Subcommand)]
pub enum UserCommand {
    /// Adds a person with a password for their first sign-in, valid for three days; generates and
    /// prints a password unless one is given
    Add(AddArgs),
    /// Sets a password for one sign-in, valid for three days, and ends all sessions; generates and
    /// prints a password unless one is given
    ResetPassword(ResetArgs),
    /// Disables a person's account and revokes their tokens; their attempts are kept
    Disable(WhoArgs),
    /// Removes the second factor of a person who has lost it: they sign in with their password
    /// only, and are notified by email
    ResetSecondFactor(WhoArgs),
    /// Creates a token for the API and prints only the token; it cannot be shown again
    Token(TokenArgs),
}

/// Options of `web-admin user add`.
#[derive(Debug, Args)]
pub struct AddArgs {
    #[command(flatten)]
    storage: StorageArgs,
    /// Email address of the account
    #[arg(long)]
    email: String,
    /// Display name
    #[arg(long)]
    name: String,
    /// Role
    #[arg(long, value_enum, default_value = "trainee")]
    role: Role,
    /// School, created if it is missing [default: the only one there is]
    #[arg(long)]
    school: Option<String>,
    /// Cohort to teach or to learn in, created if it is missing
    #[arg(long)]
    cohort: Option<String>,
    /// Password; `-` reads it from standard input, which keeps it out of the process list
    #[arg(long)]
    password: Option<String>,
    /// Also create a token for the API
    #[arg(long)]
    token: bool,
}

/// Options of `web-admin user reset-password`.
#[derive(Debug, Args)]
pub struct ResetArgs {
    #[command(flatten)]
    who: WhoArgs,
    /// Password; `-` reads it from standard input, which keeps it out of the process list
    #[arg(long)]
    password: Option<String>,
}

/// The account to act on.
#[derive(Debug, Args)]
pub struct WhoArgs {
    #[command(flatten)]
    storage: StorageArgs,
    /// Email address of the account
    #[arg(long)]
    email: String,
    /// School of the account; required if several have the address
    #[arg(long)]
    school: Option<String>,
}

/// Options of `web-admin user token`.
#[derive(Debug, Args)]
pub struct TokenArgs {
    #[command(flatten)]
    storage: StorageArgs,
    /// Email address of the token's owner; required unless --station is given
    #[arg(long, required_unless_present = "station")]
    email: Option<String>,
    /// Name of a station, whose token uploads for the trainees named by pseudonym in its recordings
    #[arg(long, conflicts_with = "email")]
    station: Option<String>,
    /// School of the station or the person [default: the only one there is]
    #[arg(long)]
    school: Option<String>,
    /// Name of a person's token
    #[arg(long, default_value = COMMAND_LINE, conflicts_with = "station")]
    name: String,
    /// Days for which a person's token is valid; a station's token is valid until it is revoked
    #[arg(long, default_value_t = LONGEST_DAYS, value_parser = clap::value_parser!(i64).range(1..=LONGEST_DAYS), conflicts_with = "station")]
    days: i64,
}

/// Default name of a token.
const COMMAND_LINE: &str = "command line";

pub(super) async fn run_user(command: &UserCommand) -> Result<(), CommandFailure> {
    match command {
        UserCommand::Add(args) => add_person(args).await,
        UserCommand::ResetPassword(args) => reset_person_password(args).await,
        UserCommand::Disable(args) => disable_person(args).await,
        UserCommand::ResetSecondFactor(args) => reset_second_factor(args).await,
        UserCommand::Token(args) => make_person_token(args).await,
    }
}

async fn add_person(args: &AddArgs) -> Result<(), CommandFailure> {
    check_email(&args.email)?;
    for (option, name) in
        [("--name", Some(&args.name)), ("--school", args.school.as_ref()), ("--cohort", args.cohort.as_ref())]
    {
        check_name(option, name.map(String::as_str))?;
    }
    let own = [args.name.as_str(), &args.email, args.school.as_deref().unwrap_or_default()];
    let (password, told) = read_password(args.password.as_deref(), &own)?;
    let state = args.storage.open().await?;
    let new = RegisteredPerson {
        email: &args.email,
        name: &args.name,
        role: args.role,
        school: args.school.as_deref(),
        cohort: args.cohort.as_deref(),
        password: &password,
        token: args.token.then_some(TokenRequest { name: COMMAND_LINE, days: LONGEST_DAYS }),
    };
    let AddedAccount { person, school, until, token } = admin_commands::add_person(&state, new).await?;
    say_line(format_args!("{} {} added to {school}; pseudonym {}", person.role, person.email, person.pseudonym));
    told.into_iter().for_each(say_line);
    say_line(good_until(until));
    token.into_iter().for_each(|token| say_line(format_args!("token: {token}")));
    Ok(())
}

async fn reset_person_password(args: &ResetArgs) -> Result<(), CommandFailure> {
    let state = args.who.storage.open().await?;
    let person = find_account(&state, &args.who.email, args.who.school.as_deref()).await?;
    let school = schools::find_school_name(state.db.reader(), person.school_id).await?;
    let (password, told) = read_password(args.password.as_deref(), &[&person.display_name, &person.email, &school])?;
    let until = admin_commands::reset_password(&state, &person, &password).await?;
    say_line(format_args!("{} has a new password and is signed out everywhere", person.email));
    told.into_iter().for_each(say_line);
    say_line(good_until(until));
    Ok(())
}

/// Explains to the administrator how long a first password is valid.
fn good_until(until: Moment) -> String {
    format!("valid for one sign-in until {until}; the person then chooses their own")
}

async fn disable_person(args: &WhoArgs) -> Result<(), CommandFailure> {
    let state = args.storage.open().await?;
    let person = find_account(&state, &args.email, args.school.as_deref()).await?;
    match admin_commands::disable_person(&state, &person).await? {
        Some(revoked) => say_line(format_args!("{} is disabled; {revoked} tokens revoked", person.email)),
        None => say_line(format_args!("{} is already disabled", person.email)),
    }
    Ok(())
}

async fn reset_second_factor(args: &WhoArgs) -> Result<(), CommandFailure> {
    let state = args.storage.open().await?;
    let person = find_account(&state, &args.email, args.school.as_deref()).await?;
    let key = PersonKey { school_id: person.school_id, person_id: person.id };
    let had_one = second_factor::reset(&state, key, Actor::CommandLine).await.map_err(anyhow::Error::from)?;
    let told = if had_one { "no longer has a second factor; notified by email" } else { "had no second factor" };
    say_line(format_args!("{} {told}", person.email));
    Ok(())
}

async fn make_person_token(args: &TokenArgs) -> Result<(), CommandFailure> {
    let state = args.storage.open().await?;
    let token = match (&args.email, &args.station) {
        (Some(email), _) => {
            let person = find_account(&state, email, args.school.as_deref()).await?;
            admin_commands::give_token(&state, &person, TokenRequest { name: &args.name, days: args.days }).await?
        }
        (None, station) => {
            check_name("--station", station.as_deref())?;
            check_name("--school", args.school.as_deref())?;
            admin_commands::give_station_token(&state, args.school.as_deref(), station.as_deref()).await?
        }
    };
    // Nothing else is printed: `> token` creates a file for `stylet upload --token-file`.
    say_line(token);
    Ok(())
}

/// Returns the account of an address, at the named school if several have it.
async fn find_account(state: &AppState, email: &str, school: Option<&str>) -> Result<Person, CommandFailure> {
    let mut found = Vec::new();
    for person in people::list_people_by_email(state.db.reader(), email).await? {
        let name = schools::find_school_name(state.db.reader(), person.school_id).await?;
        if school.is_none_or(|school| school == name) {
            found.push((person, name));
        }
    }
    let names: Vec<_> = found.iter().map(|(_, name)| format!("\"{name}\"")).collect();
    let at = school.map(|school| format!(" at the school \"{school}\"")).unwrap_or_default();
    match <[_; 1]>::try_from(found) {
        Ok([(person, _)]) => Ok(person),
        Err(_) if names.is_empty() => {
            Err(CommandFailure::Usage(format!("--email: \"{email}\"; no person has this address{at}")))
        }
        Err(_) => {
            let why = format!("--school: required; {} have a person with the address \"{email}\"", names.join(" and "));
            Err(CommandFailure::Usage(why))
        }
    }
}

/// Returns the password to set, and a line to print it if it was generated. `own` are details of
/// the account, which must not serve as a password.
fn read_password(given: Option<&str>, own: &[&str]) -> Result<(String, Option<String>), CommandFailure> {
    let password = match given {
        None => {
            let made = secret::random_password()?;
            let told = format!("password: {made}");
            return Ok((made, Some(told)));
        }
        Some("-") => std::io::read_to_string(std::io::stdin())?.trim_end_matches(['\r', '\n']).to_owned(),
        Some(given) => given.to_owned(),
    };
    let refused = |why: PasswordRefused| CommandFailure::Usage(format!("--password: {}", why.said()));
    passwords::check(&password, own).map_err(refused)?;
    Ok((password, None))
}

fn check_name(option: &str, name: Option<&str>) -> Result<(), CommandFailure> {
    match name {
        Some(name) if !is_name(name) => Err(CommandFailure::Usage(format!(
            "{option}: \"{}\"; allowed: 1 to 120 characters on one line, not beginning with = + - or @",
            on_one_line(name)
        ))),
        _ => Ok(()),
    }
}

fn check_email(email: &str) -> Result<(), CommandFailure> {
    let parts =
        email.split_once('@').filter(|(name, host)| !name.is_empty() && !host.is_empty() && !host.contains('@'));
    if parts.is_none() || email.contains(char::is_whitespace) || email.len() > 254 {
        return Err(CommandFailure::Usage(format!("--email: \"{email}\"; allowed: an address like name@example.org")));
    }
    Ok(())
}
