//! `web-admin retain`: applies the retention rules of schools.

use acts::privacy::retention;
use acts::privacy::retention::RetentionStep;
use clap::Args;
use model::privacy::retention::RetentionAction;
use store::operations::schools;
use store::privacy::retention::Settings;

use super::{CommandFailure, StorageArgs, say_line};

/// Options of `web-admin retain`.
#[derive(Debug, Args)]
pub struct RetainArgs {
    #[command(flatten)]
    storage: StorageArgs,
    /// Only print the people who would be warned or erased, and why; nothing is changed
    #[arg(long)]
    dry_run: bool,
    /// School [default: all of them]
    #[arg(long, value_name = "NAME")]
    school: Option<String>,
}

pub(super) async fn run_retain(args: &RetainArgs) -> Result<(), CommandFailure> {
    let state = args.storage.open().await?;
    let all = schools::list_schools(state.db.reader()).await?;
    let wanted: Vec<_> =
        all.iter().filter(|school| args.school.as_ref().is_none_or(|name| *name == school.name)).collect();
    if let (Some(name), true) = (&args.school, wanted.is_empty()) {
        let names: Vec<_> = all.iter().map(|school| school.name.as_str()).collect();
        return Err(CommandFailure::Usage(format!("--school: \"{name}\"; there are: {}", names.join(", "))));
    }
    for school in wanted {
        let (settings, planned) = retention::plan(&state, school.id).await.map_err(anyhow::Error::new)?;
        say_line(say_retention_rule(&school.name, settings));
        planned.iter().map(line_of_planned).for_each(say_line);
        if !args.dry_run {
            let done = retention::act(&state, school.id).await.map_err(anyhow::Error::new)?;
            say_line(format_args!(
                "  done: warned {}, withdrawn {}, erased {}",
                done.warned, done.called_off, done.erased
            ));
        }
    }
    state.db.close().await;
    Ok(())
}

fn say_retention_rule(school: &str, settings: Settings) -> String {
    match settings.months {
        None => format!("{school}: keeps everybody"),
        Some(months) => {
            format!(
                "{school}: keeps people for {months} months and warns them {} days before erasure",
                settings.warn_days
            )
        }
    }
}

/// Formats a planned step: the action, the person and the reason.
fn line_of_planned(planned: &RetentionStep) -> String {
    let RetentionStep { idle, step } = planned;
    let what = match step {
        RetentionAction::Warn => "warn".to_owned(),
        RetentionAction::Sending => "warned, email not sent yet".to_owned(),
        RetentionAction::Wait(days) => format!("warned, will be erased in {days} days at the earliest"),
        RetentionAction::Erase => "erase".to_owned(),
        RetentionAction::CallOff => "withdraw the warning".to_owned(),
    };
    let told = idle.told_at.map(|at| format!(", warned on {at}")).unwrap_or_default();
    let failed = idle.error.as_ref().map(|error| format!(", the email failed: {error}")).unwrap_or_default();
    format!(
        "  {what}: {} {} {}: last active on {}{told}{failed}",
        idle.role, idle.pseudonym, idle.email, idle.active_at
    )
}
