//! `web-admin exam`: checks an exam file without the service.

use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

use clap::{Args, Subcommand};
use model::scoring::exam_file::{
    ExamCourse, ExamEntry, ExamGrade, ExamManifest, ExamProof, ExaminedAttempt, ExaminedPerson, check,
};

use super::certificate::on_one_line;
use super::{CommandFailure, say_line};

/// `web-admin exam …`
#[derive(Debug, Subcommand)]
pub enum ExamCommand {
    /// Checks every byte of an exam file and prints its manifest; needs neither the service nor its
    /// data
    Verify(ExamArgs),
}

/// Options of `web-admin exam verify`.
#[derive(Debug, Args)]
pub struct ExamArgs {
    /// The exam file
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The public key that the school has published, 64 hexadecimal digits
    #[arg(long, value_name = "HEX")]
    key: String,
}

pub(super) fn run_exam(ExamCommand::Verify(ExamArgs { file, key }): &ExamCommand) -> Result<(), CommandFailure> {
    let opened = File::open(file).map_err(|error| CommandFailure::Usage(format!("{}: {error}", file.display())))?;
    match check(BufReader::new(opened), key) {
        Ok(manifest) => {
            lines_of_manifest(&manifest).iter().for_each(say_line);
            Ok(())
        }
        Err(why) => {
            say_line(on_one_line(&format!("not genuine: {}: {why:#}", file.display())));
            Err(CommandFailure::Found)
        }
    }
}

/// Formats every signed field.
fn lines_of_manifest(manifest: &ExamManifest) -> Vec<String> {
    // Destructured without `..`, so that a new field of the manifest must be added here.
    let ExamManifest {
        kind: _,
        format: _,
        id,
        school,
        person,
        attempt,
        grade,
        proof,
        courses,
        frozen_by,
        frozen_at,
        scope,
        entries,
    } = manifest;
    let ExaminedPerson { name, registrar_id, pseudonym } = person;
    let number = registrar_id.as_ref().map_or_else(String::new, |number| format!(" ({number})"));
    let mut lines = vec![
        format!("genuine: exam file {id} of {name}{number} at {school}, frozen by {frozen_by} at {frozen_at}"),
        format!("  pseudonym {pseudonym}"),
    ];
    lines.extend(lines_of_attempt(attempt));
    lines.extend(lines_of_result(grade, proof));
    lines.extend(courses.iter().flat_map(lines_of_course));
    lines.push(format!("  scope     {scope}"));
    let entry = |ExamEntry { name, bytes, sha256 }: &ExamEntry| format!("  {sha256} {bytes:>12} {name}");
    lines.extend(entries.iter().map(entry));
    lines.iter().map(|line| on_one_line(line)).collect()
}

fn lines_of_attempt(attempt: &ExaminedAttempt) -> [String; 3] {
    let ExaminedAttempt {
        id,
        exercise_id,
        exercise,
        exercise_sha256,
        scene_sha256,
        published,
        started_at,
        received_at,
        duration_s,
    } = attempt;
    let published = if *published { "published by the school" } else { "never published by the school" };
    [
        format!("  attempt   {id}, started {started_at}, received {received_at}, {duration_s} s"),
        format!("  exercise  “{exercise}” ({exercise_id}), revision {exercise_sha256}, {published}"),
        format!("  scene     revision {scene_sha256}"),
    ]
}

fn lines_of_result(grade: &ExamGrade, proof: &ExamProof) -> [String; 3] {
    let ExamGrade { score, passed, overridden, rubric_sha256 } = grade;
    let ExamProof { signed, resimulated, supervised, needed, counts, uncounted } = proof;
    let passed = if *passed { "passed" } else { "failed" };
    let by = if *overridden { "set by a person" } else { "computed" };
    let uncounted = uncounted.as_ref().map_or_else(String::new, |why| format!(" ({why})"));
    [
        format!("  grade     {score} of 100, {passed}, {by}; rubric {rubric_sha256}"),
        format!("  proofs    signed: {signed}, re-simulated: {resimulated}, supervised: {supervised}"),
        format!("  counts    {counts}{uncounted}; the school accepts {needed}"),
    ]
}

fn lines_of_course(course: &ExamCourse) -> [String; 2] {
    let ExamCourse { id, title, sha256, rule, exercise_mastered_at, course_mastered_at } = course;
    let since =
        |at: &Option<String>| at.as_ref().map_or_else(|| "not mastered".to_owned(), |at| format!("mastered {at}"));
    let (exercise, course) = (since(exercise_mastered_at), since(course_mastered_at));
    [
        format!("  course    “{title}” ({id}), revision {sha256}: exercise {exercise}, course {course}"),
        format!("  rule      an exercise is {rule}"),
    ]
}

#[cfg(test)]
mod tests {
    //! Fails when a signed field is not printed, or a name starts a line of its own.

    use super::*;

    #[test]
    fn every_signed_field_is_printed_on_its_line() {
        let text = include_str!("../../../tests/data/exam_file/manifest.json").replace("Ada Ek", "Ada\\ngenuine: Bob");
        let manifest: ExamManifest = serde_json::from_str(&text).expect("a manifest");
        let lines = lines_of_manifest(&manifest);
        assert!(lines.iter().all(|line| !line.contains(char::is_control)), "{lines:?}");
        assert_eq!(lines.iter().filter(|line| line.starts_with("genuine")).count(), 1);
        let all = lines.join("\n");
        let mut texts = Vec::new();
        let signed = serde_json::to_value(&manifest).expect("JSON");
        list_texts(&signed, &mut texts);
        for text in texts.iter().filter(|text| *text != ExamManifest::KIND) {
            assert!(all.contains(&on_one_line(text)), "{text} is not printed:\n{all}");
        }
    }

    fn list_texts(value: &serde_json::Value, texts: &mut Vec<String>) {
        match value {
            serde_json::Value::String(text) => texts.push(text.clone()),
            serde_json::Value::Array(all) => all.iter().for_each(|value| list_texts(value, texts)),
            serde_json::Value::Object(all) => all.values().for_each(|value| list_texts(value, texts)),
            _ => {}
        }
    }
}
