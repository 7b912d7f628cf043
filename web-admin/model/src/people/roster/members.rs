//! Members of a course of a learning platform, compared with the people of the school.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use uuid::Uuid;

use super::{
    Leaving, LineOutcome, Refusal, RosterChange, RosterDifference, RosterEntry, RosterOutcome, RosterRequest,
    SchoolPerson, check_text,
};
use crate::Role;
use crate::ids::{PersonId, PlatformId};
use crate::people::email::make_absent_email;

/// A member of a course, as the learning platform describes them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CourseMember {
    /// Id at the platform.
    pub subject: String,
    /// Name, if the platform sends it.
    pub name: Option<String>,
    /// Email address, normalized, if the platform sends it.
    pub email: Option<String>,
    /// Registration number.
    pub number: Option<String>,
    /// Learns in the course, and does not teach.
    pub is_learner: bool,
}

/// The members of a course.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CourseRoster {
    /// Learning platform.
    pub platform_id: PlatformId,
    /// Issuer of the identities of its users.
    pub issuer: String,
    /// The members.
    pub members: Vec<CourseMember>,
}

/// An identity that a person gets from a roster, so that their first launch finds them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemberIdentity {
    /// Learning platform.
    pub platform_id: PlatformId,
    /// Issuer.
    pub issuer: String,
    /// Id at the platform.
    pub subject: String,
}

/// A person of the school who may be a member.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KnownMember {
    /// The person.
    pub person: SchoolPerson,
    /// What the platform calls them, if it is known.
    pub subject: Option<String>,
}

/// What a roster is compared with.
#[derive(Clone, Copy, Debug)]
pub struct KnownMembers<'a> {
    /// People with an identity, a number or the cohort of the roster.
    pub people: &'a [KnownMember],
    /// Addresses of other accounts.
    pub taken_emails: &'a BTreeSet<String>,
}

impl CourseRoster {
    /// Compares the members with the people of a school, as launches do: by the identity, then by the
    /// registration number, never by the address. Nobody's name, address or number changes.
    #[must_use]
    pub fn compare(&self, known: KnownMembers<'_>, wanted: &RosterRequest) -> RosterDifference {
        let mut reading = Reading { roster: self, known, wanted, seen: Seen::default(), present: BTreeSet::new() };
        let numbered = (1..).zip(&self.members);
        let lines = numbered.map(|(line, member)| reading.line(line, member)).collect();
        let leaving = if wanted.remove_missing { reading.leaving() } else { Vec::new() };
        RosterDifference { lines, leaving }
    }

    /// Returns what the platform calls a member, made unreadable: for members without a name, and for
    /// the address of those who have none.
    fn pseudonym(&self, member: &CourseMember) -> Uuid {
        let hash = Sha256::digest(format!("{}\n{}", self.issuer, member.subject));
        let mut bytes = [0; 16];
        bytes.copy_from_slice(&hash[..16]);
        Uuid::from_bytes(bytes)
    }

    fn name_of(&self, member: &CourseMember) -> String {
        match &member.name {
            Some(name) => name.clone(),
            None => format!("Member {}", &self.pseudonym(member).simple().to_string()[..8]),
        }
    }

    fn identity_of(&self, member: &CourseMember) -> MemberIdentity {
        let (platform_id, issuer) = (self.platform_id, self.issuer.clone());
        MemberIdentity { platform_id, issuer, subject: member.subject.clone() }
    }
}

/// First lines of members, by what must not repeat.
#[derive(Default)]
struct Seen<'a> {
    subjects: BTreeMap<&'a str, u64>,
    numbers: BTreeMap<&'a str, u64>,
    emails: BTreeMap<&'a str, u64>,
}

/// A comparison in progress.
struct Reading<'a> {
    roster: &'a CourseRoster,
    known: KnownMembers<'a>,
    wanted: &'a RosterRequest,
    seen: Seen<'a>,
    /// People who are members.
    present: BTreeSet<PersonId>,
}

impl<'a> Reading<'a> {
    fn line(&mut self, line: u64, member: &'a CourseMember) -> LineOutcome {
        let name = self.roster.name_of(member);
        let shown = member.email.as_ref().map_or_else(|| name.clone(), |email| format!("{name} <{email}>"));
        let (entry, outcome) = match self.outcome(line, member) {
            Ok(found) => found,
            Err(outcome) => (None, outcome),
        };
        LineOutcome { line, shown, entry, outcome }
    }

    fn outcome(
        &mut self,
        line: u64,
        member: &'a CourseMember,
    ) -> Result<(Option<RosterEntry>, RosterOutcome), RosterOutcome> {
        if let Some(first) = self.seen.subjects.get(member.subject.as_str()) {
            return Err(RosterOutcome::Together(*first));
        }
        self.seen.subjects.insert(&member.subject, line);
        let by_subject = self.find(|known| known.subject.as_deref() == Some(&member.subject));
        let number = member.number.as_deref();
        let by_number = self.find(|known| number.is_some() && known.person.registrar_id.as_deref() == number);
        let found = by_subject.or(by_number);
        self.present.extend(found.map(|known| known.person.id));
        self.check(line, member, found).map_err(RosterOutcome::Refused)?;
        Ok(match found {
            Some(known) => self.compare_known(member, known),
            None => (Some(self.entry_of_new(member)), RosterOutcome::New),
        })
    }

    fn find(&self, is_meant: impl Fn(&KnownMember) -> bool) -> Option<&'a KnownMember> {
        self.known.people.iter().find(|known| is_meant(known))
    }

    fn check(&mut self, line: u64, member: &'a CourseMember, found: Option<&KnownMember>) -> Result<(), Refusal> {
        if let Some(known) = found {
            if known.person.role != Role::Trainee {
                return Err(Refusal::OtherRole(known.person.role));
            }
            if known.subject.as_ref().is_some_and(|subject| *subject != member.subject) {
                return Err(Refusal::NumberOfAnother);
            }
        }
        if !member.is_learner {
            return Err(Refusal::NoLearner);
        }
        if found.is_some() {
            return Ok(());
        }
        for text in [&member.name, &member.number].into_iter().flatten() {
            check_text(text)?;
        }
        if let Some(number) = &member.number
            && let Some(first) = self.seen.numbers.insert(number, line)
        {
            return Err(Refusal::SameRegistrarId(first));
        }
        if let Some(email) = &member.email {
            if self.known.taken_emails.contains(email) {
                return Err(Refusal::EmailOfAnother);
            }
            if let Some(first) = self.seen.emails.insert(email, line) {
                return Err(Refusal::SameEmail(first));
            }
        }
        Ok(())
    }

    /// Compares a member with the person that they are; the entry repeats what is stored.
    fn compare_known(&self, member: &CourseMember, known: &KnownMember) -> (Option<RosterEntry>, RosterOutcome) {
        let person = &known.person;
        let joined = self.wanted.cohort.iter().filter(|cohort| !person.cohorts.contains(cohort));
        let mut changes: Vec<_> = joined.map(|cohort| RosterChange::Joins(cohort.clone())).collect();
        let identity = known.subject.is_none().then(|| self.roster.identity_of(member));
        changes.extend(identity.as_ref().map(|_| RosterChange::Identity));
        let entry = RosterEntry {
            email: person.email.clone(),
            name: person.name.clone(),
            registrar_id: person.registrar_id.clone(),
            cohorts: self.wanted.cohort.iter().cloned().collect(),
            role: None,
            standing: None,
            identity,
        };
        let outcome = match changes.is_empty() {
            true => RosterOutcome::Unchanged,
            false => RosterOutcome::Changed { person: person.id, changes },
        };
        (Some(entry), outcome)
    }

    fn entry_of_new(&self, member: &CourseMember) -> RosterEntry {
        let absent = || make_absent_email(self.roster.pseudonym(member));
        RosterEntry {
            email: member.email.clone().unwrap_or_else(absent),
            name: self.roster.name_of(member),
            registrar_id: member.number.clone(),
            cohorts: self.wanted.cohort.iter().cloned().collect(),
            role: Some(Role::Trainee),
            standing: None,
            identity: Some(self.roster.identity_of(member)),
        }
    }

    /// Returns the trainees of the cohort whom the platform knows, and who are no members any more.
    /// Others have joined the cohort in another way.
    fn leaving(&self) -> Vec<Leaving> {
        let Some(cohort) = &self.wanted.cohort else { return Vec::new() };
        let is_gone = |known: &&KnownMember| {
            let person = &known.person;
            known.subject.is_some()
                && person.role == Role::Trainee
                && person.cohorts.contains(cohort)
                && !self.present.contains(&person.id)
        };
        let leaving = |known: &KnownMember| Leaving {
            person: known.person.id,
            name: known.person.name.clone(),
            cohort: cohort.clone(),
        };
        let mut gone: Vec<_> = self.known.people.iter().filter(is_gone).map(leaving).collect();
        gone.dedup();
        gone
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn member(subject: &str) -> CourseMember {
        CourseMember {
            subject: subject.to_owned(),
            name: Some(format!("Name of {subject}")),
            email: None,
            number: None,
            is_learner: true,
        }
    }

    fn known(id: u128, subject: Option<&str>) -> KnownMember {
        let person = SchoolPerson {
            id: PersonId::from_u128(id),
            registrar_id: Some(format!("n{id}")),
            email: format!("p{id}@example.org"),
            name: format!("Person {id}"),
            role: Role::Trainee,
            enabled: true,
            cohorts: vec!["Spring".to_owned()],
        };
        KnownMember { person, subject: subject.map(str::to_owned) }
    }

    fn compare(members: Vec<CourseMember>, people: &[KnownMember]) -> RosterDifference {
        let roster = CourseRoster { platform_id: PlatformId::nil(), issuer: "https://lms a1".to_owned(), members };
        let taken_emails = &BTreeSet::from(["taken@example.org".to_owned()]);
        let wanted = RosterRequest { cohort: Some("Spring".to_owned()), remove_missing: true, ..Default::default() };
        roster.compare(KnownMembers { people, taken_emails }, &wanted)
    }

    fn outcomes(difference: RosterDifference) -> Vec<RosterOutcome> {
        difference.lines.into_iter().map(|line| line.outcome).collect()
    }

    #[test]
    fn members_are_found_by_identity_then_by_number() {
        let by_number = CourseMember { number: Some("n2".to_owned()), ..member("b") };
        let people = [known(1, Some("a")), known(2, None)];
        let difference = compare(vec![member("a"), by_number, member("c")], &people);
        let [a, b, c] = &difference.lines[..] else { panic!("{difference:?}") };
        assert_eq!((&a.outcome, &c.outcome), (&RosterOutcome::Unchanged, &RosterOutcome::New));
        let changes = vec![RosterChange::Identity];
        assert_eq!(b.outcome, RosterOutcome::Changed { person: people[1].person.id, changes });
        let entry = b.entry.as_ref().unwrap();
        assert_eq!((entry.name.as_str(), entry.email.as_str()), ("Person 2", "p2@example.org"), "details are kept");
        assert_eq!(entry.identity.as_ref().unwrap().subject, "b");
    }

    #[test]
    fn nobody_is_dropped_or_taken_in_twice() {
        let nameless = CourseMember { name: None, ..member("x") };
        let staff = CourseMember { is_learner: false, ..member("t") };
        let address = |email: &str| Some(email.to_owned());
        let taken = CourseMember { email: address("taken@example.org"), ..member("e") };
        let twice = CourseMember { number: Some("n1".to_owned()), ..member("f") };
        let formula = CourseMember { name: Some("=1+1".to_owned()), ..member("g") };
        let difference = compare(vec![nameless, member("x"), staff, taken, twice, formula], &[known(1, Some("a"))]);
        assert!(difference.lines[0].shown.starts_with("Member "), "{difference:?}");
        assert!(difference.lines[0].entry.as_ref().unwrap().email.len() > 32);
        let refused = [
            Refusal::NoLearner,
            Refusal::EmailOfAnother,
            Refusal::NumberOfAnother,
            Refusal::Formula("=1+1".to_owned()),
        ];
        let expected = [RosterOutcome::New, RosterOutcome::Together(1)];
        let expected: Vec<_> = expected.into_iter().chain(refused.map(RosterOutcome::Refused)).collect();
        assert_eq!(outcomes(difference), expected);
    }

    #[test]
    fn only_trainees_whom_the_platform_knows_leave() {
        let teacher = KnownMember {
            person: SchoolPerson { role: Role::Instructor, ..known(3, None).person },
            subject: Some("t".to_owned()),
        };
        let people = [known(1, Some("a")), known(2, None), teacher, known(4, Some("d"))];
        let difference = compare(vec![member("d")], &people);
        let gone: Vec<PersonId> = difference.leaving.iter().map(|leaving| leaving.person).collect();
        assert_eq!(gone, [people[0].person.id]);
        let staff = CourseMember { is_learner: false, ..member("a") };
        assert!(compare(vec![staff, member("d")], &people).leaving.is_empty(), "still in the course");
    }
}
