//! `web-admin user`: adding people and giving them access.

use acts::registry::{AddedAccount, RegisteredPerson};
use acts::tokens::{LONGEST_DAYS, TokenRequest};
use acts::{passwords, registry, second_factor, secret};
use clap::{Args, Subcommand};
use model::line::on_one_line;
use model::password_refused::PasswordRefused;
use model::roster::is_name;
use model::{Moment, PersonKey, Role};
use store::audit::Actor;
use store::people::{self, Person};
use store::schools;

use super::{CommandFailure, StorageArgs, say_line};
use crate::AppState;

/// `web-admin user …`
#[derive(Debug, Subcommand)]
pub enum UserCommand {
    /// Adds a person with a password for their first sign-in, good for three days; prints it where none is given
    Add(AddArgs),
    /// Sets a password for one sign-in, good for three days, which ends every earlier one; prints it where none is given
    ResetPassword(ResetArgs),
    /// Keeps a person from signing in and revokes their tokens; their attempts stay
    Disable(WhoArgs),
    /// Takes a person's second factor away who has lost it: their password alone signs them in, and a mail tells them
    ResetSecondFactor(WhoArgs),
    /// Makes a token for the API and prints it alone, this once
    Token(TokenArgs),
}

/// A new person.
#[derive(Debug, Args)]
pub struct AddArgs {
    #[command(flatten)]
    who: WhoArgs,
    /// Name shown to people
    #[arg(long)]
    name: String,
    /// What they may do
    #[arg(long, value_enum, default_value = "trainee")]
    role: Role,
    /// School, made where it is missing [default: the only one there is]
    #[arg(long)]
    school: Option<String>,
    /// Cohort to teach or to learn in, made where it is missing
    #[arg(long)]
    cohort: Option<String>,
    /// Password; `-` reads it from standard input, which keeps it out of the list of processes
    #[arg(long)]
    password: Option<String>,
    /// Make a token for the API too
    #[arg(long)]
    token: bool,
}

/// A new password.
#[derive(Debug, Args)]
pub struct ResetArgs {
    #[command(flatten)]
    who: WhoArgs,
    /// Password; `-` reads it from standard input, which keeps it out of the list of processes
    #[arg(long)]
    password: Option<String>,
}

/// Who is meant.
#[derive(Debug, Args)]
pub struct WhoArgs {
    #[command(flatten)]
    storage: StorageArgs,
    /// Address they sign in with
    #[arg(long)]
    email: String,
}

/// A new token.
#[derive(Debug, Args)]
pub struct TokenArgs {
    #[command(flatten)]
    storage: StorageArgs,
    /// Whose, or
    #[arg(long, required_unless_present = "station")]
    email: Option<String>,
    /// the name of a station, which uploads for whoever its recordings name by pseudonym
    #[arg(long, conflicts_with = "email")]
    station: Option<String>,
    /// The station's school [default: the only one there is]
    #[arg(long)]
    school: Option<String>,
    /// What a person's token is called
    #[arg(long, default_value = COMMAND_LINE, conflicts_with = "station")]
    name: String,
    /// Days that a person's token is good for; a station's is good until it is revoked
    #[arg(long, default_value_t = LONGEST_DAYS, value_parser = clap::value_parser!(i64).range(1..=LONGEST_DAYS), conflicts_with = "station")]
    days: i64,
}

/// What a token is called that nobody has named.
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
    check_email(&args.who.email)?;
    for (option, name) in
        [("--name", Some(&args.name)), ("--school", args.school.as_ref()), ("--cohort", args.cohort.as_ref())]
    {
        check_name(option, name.map(String::as_str))?;
    }
    let own = [args.name.as_str(), &args.who.email, args.school.as_deref().unwrap_or_default()];
    let (password, told) = read_password(args.password.as_deref(), &own)?;
    let state = args.who.storage.open().await?;
    let new = RegisteredPerson {
        email: &args.who.email,
        name: &args.name,
        role: args.role,
        school: args.school.as_deref(),
        cohort: args.cohort.as_deref(),
        password: &password,
        token: args.token.then_some(TokenRequest { name: COMMAND_LINE, days: LONGEST_DAYS }),
    };
    let AddedAccount { person, school, until, token } = registry::add_person(&state, new).await?;
    say_line(format_args!("{} {} added to {school}; pseudonym {}", person.role, person.email, person.pseudonym));
    told.into_iter().for_each(say_line);
    say_line(good_until(until));
    token.into_iter().for_each(|token| say_line(format_args!("token: {token}")));
    Ok(())
}

async fn reset_person_password(args: &ResetArgs) -> Result<(), CommandFailure> {
    let state = args.who.storage.open().await?;
    let person = find_account(&state, &args.who.email).await?;
    let school = schools::find_school_name(state.db.reader(), person.school_id).await?;
    let (password, told) = read_password(args.password.as_deref(), &[&person.display_name, &person.email, &school])?;
    let until = registry::reset_password(&state, &person, &password).await?;
    say_line(format_args!("{} has a new password and is signed out everywhere", person.email));
    told.into_iter().for_each(say_line);
    say_line(good_until(until));
    Ok(())
}

/// What whoever sets a password for somebody else is told of it.
fn good_until(until: Moment) -> String {
    format!("signing in with it once, until {until}, asks them to choose their own")
}

async fn disable_person(args: &WhoArgs) -> Result<(), CommandFailure> {
    let state = args.storage.open().await?;
    let person = find_account(&state, &args.email).await?;
    match registry::disable_person(&state, &person).await? {
        Some(revoked) => say_line(format_args!("{} is disabled; {revoked} tokens revoked", person.email)),
        None => say_line(format_args!("{} was disabled before", person.email)),
    }
    Ok(())
}

async fn reset_second_factor(args: &WhoArgs) -> Result<(), CommandFailure> {
    let state = args.storage.open().await?;
    let person = find_account(&state, &args.email).await?;
    let key = PersonKey { school_id: person.school_id, person_id: person.id };
    let had_one = second_factor::reset(&state, key, Actor::CommandLine).await.map_err(anyhow::Error::from)?;
    let told = if had_one { "has no second factor any more; a mail tells them" } else { "had no second factor" };
    say_line(format_args!("{} {told}", person.email));
    Ok(())
}

async fn make_person_token(args: &TokenArgs) -> Result<(), CommandFailure> {
    let state = args.storage.open().await?;
    let token = match (&args.email, &args.station) {
        (Some(email), _) => {
            let person = find_account(&state, email).await?;
            registry::give_token(&state, &person, TokenRequest { name: &args.name, days: args.days }).await?
        }
        (None, station) => {
            check_name("--station", station.as_deref())?;
            check_name("--school", args.school.as_deref())?;
            registry::give_station_token(&state, args.school.as_deref(), station.as_deref()).await?
        }
    };
    // Nothing else: `> token` makes a file that `stylet upload --token-file` reads.
    say_line(token);
    Ok(())
}

async fn find_account(state: &AppState, email: &str) -> Result<Person, CommandFailure> {
    let found = people::find_person_by_email(state.db.reader(), email).await?;
    found.ok_or_else(|| CommandFailure::Usage(format!("--email: \"{email}\"; nobody has this address")))
}

/// The password to set, and a line that tells it where it was made here. `own` is who it is for.
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
            "{option}: \"{}\"; allowed are 1 to 120 characters on one line, not beginning with = + - or @",
            on_one_line(name)
        ))),
        _ => Ok(()),
    }
}

fn check_email(email: &str) -> Result<(), CommandFailure> {
    let parts =
        email.split_once('@').filter(|(name, host)| !name.is_empty() && !host.is_empty() && !host.contains('@'));
    if parts.is_none() || email.contains(char::is_whitespace) || email.len() > 254 {
        return Err(CommandFailure::Usage(format!("--email: \"{email}\"; an address like name@example.org is needed")));
    }
    Ok(())
}
