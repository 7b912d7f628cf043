//! Rosters from practice. The tests check that files that a registrar considers valid are accepted,
//! that invalid ones are refused, and that the difference contains exactly the actual changes.

use super::*;
use crate::ids::PersonId;

fn entries(text: &str) -> Vec<RosterEntry> {
    read(text.as_bytes()).unwrap().rows.into_iter().map(|row| row.entry.unwrap()).collect()
}

fn refusals(text: &str) -> Vec<(u64, Refusal)> {
    let rows = read(text.as_bytes()).unwrap().rows;
    rows.into_iter().filter_map(|row| Some((row.line, row.entry.err()?.refusal))).collect()
}

#[test]
fn excel_in_german() {
    let file = "\u{feff}Matrikelnummer;Nachname;Vorname;E-Mail-Adresse;Gruppe\r\n\
                4711;\"Müller; Dr.\";Jörg;J.Mueller@Example.ORG;\"Jahr 4, A\"\r\n;;;;\r\n";
    let [entry] = entries(file).try_into().unwrap();
    assert_eq!((entry.name.as_str(), entry.email.as_str()), ("Jörg Müller; Dr.", "j.mueller@example.org"));
    assert_eq!(
        (entry.registrar_id.as_deref(), entry.cohorts.as_slice()),
        (Some("4711"), &["Jahr 4, A".to_owned()][..])
    );
}

#[test]
fn canvas() {
    let file = "user_id,login_id,password,first_name,last_name,email,status\n\
                U1,ana1,,Ana,Lindqvist,ana@example.org,active\nU2,bo@example.org,,Bo,Ek,,deleted\n";
    let roster = read(file.as_bytes()).unwrap();
    assert_eq!(roster.ignored, ["password"]);
    let entries = entries(file);
    assert_eq!(entries[0].standing, Some(AccountStanding::Active));
    assert_eq!((entries[1].email.as_str(), entries[1].standing), ("bo@example.org", Some(AccountStanding::Gone)));
}

fn doubts(text: &str) -> Vec<MappingDoubt> {
    RosterTable::read(text.as_bytes()).unwrap().guess().doubts
}

#[test]
fn what_is_not_certain_is_asked() {
    assert_eq!(doubts("Vorname;Nachname\nA;B\n"), [MappingDoubt::NoEmail]);
    assert_eq!(doubts("email,first_name\na@b.c,A\n"), [MappingDoubt::NoName]);
    let alike = MappingDoubt::Alike("email".to_owned(), "mail".to_owned());
    assert_eq!(doubts("email,mail,name\na@b.c,a@d.e,A\n"), [alike]);
    assert_eq!(doubts("email,mail,name\na@b.c,,A\n"), [], "what is empty tells nothing");
    assert_eq!(doubts("email,name,status\na@b.c,A,x\n"), [MappingDoubt::Unclear("status".to_owned())]);
    assert_eq!(doubts("Student,SIS Login ID\nA,a\n"), [MappingDoubt::NoEmail]);
    for empty in ["", "email,name\n"] {
        assert_eq!(read(empty.as_bytes()), Err(Unreadable::Empty));
    }
}

#[test]
fn an_address_without_a_domain_is_refused_as_such() {
    let file = "email,name\nanna@,A\nanna,B\nanna@localhost,C\n@b.c,D\n";
    let told: Vec<Refusal> = refusals(file).into_iter().map(|(_, refusal)| refusal).collect();
    let bare = |text: &str| Refusal::NoDomain(text.to_owned());
    assert_eq!(told[..3], [bare("anna@"), bare("anna"), bare("anna@localhost")]);
    assert_eq!(told[3], Refusal::BadEmail("@b.c".to_owned()));
}

#[test]
fn names_are_read_given_name_first() {
    for (name, read_as) in [
        ("Ek, Ana", "Ana Ek"),
        ("von der Aue, Dr. Jörg", "Dr. Jörg von der Aue"),
        ("Ana Ek, MD", "Ana Ek, MD"),
        ("Ana Ek", "Ana Ek"),
    ] {
        let [entry] = entries(&format!("email;name\na@b.c;{name}\n")).try_into().unwrap();
        assert_eq!(entry.name, read_as);
    }
    let [entry] = entries("Name;Vorname;E-Mail\nEk;Ana;a@b.c\n").try_into().unwrap();
    assert_eq!(entry.name, "Ana Ek", "beside a given name, Name is the family's");
}

#[test]
fn several_groups_stand_in_one_field() {
    let groups = |file: &str| entries(file).remove(0).cohorts;
    assert_eq!(groups("email,name,Groups\na@b.c,A,\"G 1, G 2\"\n"), ["G 1", "G 2"]);
    assert_eq!(groups("email,name,Section\na@b.c,A,G 1; G 2; G 1\n"), ["G 1", "G 2"]);
}

/// Returns a file with real column names of other systems and invented people.
fn shipped(name: &str) -> Vec<u8> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/rosters");
    std::fs::read(folder.join(name)).unwrap()
}

#[test]
fn workbook_keeps_zeros_of_text_and_adds_no_decimals() {
    let roster = read(&shipped("excel.xlsx")).unwrap();
    let numbers: Vec<_> = roster.rows.iter().map(|row| row.entry.as_ref().unwrap().registrar_id.clone()).collect();
    assert_eq!(numbers, [Some("0012345".to_owned()), Some("23456".to_owned())]);
    assert_eq!(roster.rows[0].line, 2);
}

#[test]
fn a_workbook_that_unpacks_to_too_much_is_refused() {
    assert_eq!(read(&shipped("bomb.xlsx")), Err(Unreadable::TooMuch));
    assert_eq!(read(&shipped("strings.xlsx")), Err(Unreadable::TooMuch), "room for strings that are not there");
    assert_eq!(read(&[0xD0, 0xCF, 0x11, 0xE0, 0xA1]), Err(Unreadable::OldExcel));
    assert_eq!(read(b"PK\x03\x04 and no more"), Err(Unreadable::NotSheet));
}

proptest::proptest! {
    #[test]
    fn no_bytes_make_the_reader_fall(bytes in proptest::collection::vec(proptest::num::u8::ANY, 0..2000)) {
        let _ = read(&bytes);
    }

    #[test]
    fn no_damage_to_a_workbook_makes_the_reader_fall(at in 0_usize..4000, byte in proptest::num::u8::ANY, cut in 0_usize..4000) {
        let mut book = shipped("excel.xlsx");
        let length = book.len();
        book[at % length] = byte;
        let _ = read(&book);
        let _ = read(&book[..cut % length]);
    }

    #[test]
    fn no_table_makes_the_reader_fall(text in "[a-z@.,;\"\n =]{0,400}") {
        for head in ["email,name,groups\n", "Vorname;Nachname;Mtknr;Status\n", ""] {
            let _ = read(format!("{head}{text}").as_bytes());
        }
    }
}

#[test]
fn invalid_roster_line_is_rejected_and_valid_ones_remain() {
    let file = "email,name,role,status\na@b.c,Ana,,\nA@B.C,Again,,\nnobody,Bo,,\nd@b.c,,,\n,Cy,,\n\
                e@b.c,=HYPERLINK(1),,\nf@b.c,\"-2+3\",,\ng@b.c,Gil,king,\nh@b.c,Hal,student,asleep\ni@b.c,Ida,teacher,aktiv\n";
    let formula = |text: &str| Refusal::Formula(text.to_owned());
    assert_eq!(
        refusals(file),
        [
            (3, Refusal::SameEmail(2)),
            (4, Refusal::NoDomain("nobody".to_owned())),
            (5, Refusal::NoName),
            (6, Refusal::NoEmail),
            (7, formula("=HYPERLINK(1)")),
            (8, formula("-2+3")),
            (9, Refusal::BadRole("king".to_owned())),
            (10, Refusal::BadStatus("asleep".to_owned())),
        ]
    );
}

#[test]
fn a_hundred_thousand_lines_are_too_many() {
    let lines: String = (0..100_000).map(|n| format!("p{n}@example.org,Person {n}\n")).collect();
    assert_eq!(read(format!("email,name\n{lines}").as_bytes()), Err(Unreadable::TooLong));
}

fn known(number: u128, registrar: Option<&str>, email: &str, cohorts: &[&str]) -> SchoolPerson {
    SchoolPerson {
        id: PersonId::from_u128(number),
        registrar_id: registrar.map(str::to_owned),
        email: email.to_owned(),
        name: "Ana Ek".to_owned(),
        role: Role::Trainee,
        enabled: true,
        cohorts: cohorts.iter().map(|cohort| (*cohort).to_owned()).collect(),
    }
}

fn outcomes(file: &str, people: &[SchoolPerson], wanted: &RosterRequest) -> Vec<RosterOutcome> {
    let difference = RosterDifference::of(&read(file.as_bytes()).unwrap(), people, wanted);
    difference.lines.into_iter().map(|line| line.outcome).collect()
}

#[test]
fn the_number_finds_a_person_whose_address_and_name_are_new() {
    let people = [known(1, Some("7"), "ana@b.c", &["A"]), known(2, None, "bo@b.c", &[])];
    let file = "id,email,name,cohort\n7,ana.new@b.c,Ana Berg,A\n,bo@b.c,Ana Ek,\n8,bo@b.c,Ana Ek,\n9,new@b.c,New,B\n";
    let [moved, numbered, together, new] = outcomes(file, &people, &RosterRequest::default()).try_into().unwrap();
    let changes = vec![RosterChange::Name("Ana Ek".to_owned()), RosterChange::Email("ana@b.c".to_owned())];
    assert_eq!(moved, RosterOutcome::Changed { person: PersonId::from_u128(1), changes });
    let changes = vec![RosterChange::RegistrarId(None)];
    assert_eq!(numbered, RosterOutcome::Changed { person: PersonId::from_u128(2), changes }, "by line 4");
    assert_eq!((together, new), (RosterOutcome::Together(3), RosterOutcome::New));
}

#[test]
fn nobody_is_taken_for_somebody_else() {
    let mut people = [known(1, Some("7"), "ana@b.c", &[]), known(2, None, "bo@b.c", &[])];
    people[1].role = Role::Administrator;
    let file = "id,email,name\n7,bo@b.c,Ana Ek\n";
    let expected = [RosterOutcome::Refused(Refusal::EmailOfAnother)];
    assert_eq!(outcomes(file, &people, &RosterRequest::default()), expected);
    let administrator = outcomes("email,name\nbo@b.c,Bo\n", &people, &RosterRequest::default());
    assert_eq!(administrator, [RosterOutcome::Refused(Refusal::OtherRole(Role::Administrator))]);
}

#[test]
fn people_missing_from_the_file_leave_only_when_requested() {
    let people = [known(1, None, "ana@b.c", &["A", "B"]), known(2, None, "bo@b.c", &["A"])];
    let roster = read(b"email,name\nbo@b.c,Ana Ek\n").unwrap();
    let leaving = |remove_missing| {
        let wanted = RosterRequest { cohort: Some("A".to_owned()), remove_missing, ..RosterRequest::default() };
        RosterDifference::of(&roster, &people, &wanted).leaving
    };
    assert_eq!(leaving(false), []);
    let [only] = leaving(true).try_into().unwrap();
    assert_eq!((only.person, only.cohort.as_str()), (PersonId::from_u128(1), "A"));
}

#[test]
fn a_line_has_the_number_that_an_editor_shows_whatever_ends_it() {
    for end in ["\n", "\r\n"] {
        let file = ["email,name", "a@b.c,Ana", "", "b@b.c,Bo", "no address,Cy", ""].join(end);
        for (head, more) in [(String::new(), 0), (format!("sep=,{end}"), 1)] {
            let rows = read(format!("{head}{file}").as_bytes()).unwrap().rows;
            let lines: Vec<u64> = rows.iter().map(|row| row.line - more).collect();
            assert_eq!(lines, [2, 4, 5], "{end:?}");
        }
    }
}

#[test]
fn every_roster_that_is_a_bomb_is_answered() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fuzz/bombs/roster");
    let bombs: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(bombs.len() >= 4, "{bombs:?}");
    for path in bombs {
        let told = read(&std::fs::read(&path).unwrap());
        assert!(told.is_err() || told.is_ok_and(|roster| roster.rows.len() <= 1000), "{}", path.display());
    }
}

#[test]
fn whoever_stands_in_a_refused_line_does_not_leave() {
    let person = |number: u128, name: &str| {
        let email = format!("r{number}@uni.example");
        SchoolPerson { name: name.to_owned(), ..known(number, Some(&format!("R{number}")), &email, &["Rem"]) }
    };
    let people = [
        person(1, "Rita One"),
        person(2, "Rolf Two"),
        person(3, "Rosa Three"),
        person(4, "Rudi Four"),
        person(5, "Ruth Five"),
    ];
    let head = "email,name,user_id,cohort,status\nr1@uni.example,Rita One,R1,Rem,active\n";
    let wanted = RosterRequest { cohort: None, remove_missing: true, ..RosterRequest::default() };
    let leaving = |lines: &str| {
        let roster = read(format!("{head}{lines}").as_bytes()).unwrap();
        let left = RosterDifference::of(&roster, &people, &wanted).leaving;
        left.into_iter().map(|leaving| leaving.name).collect::<Vec<_>>()
    };
    let most = [
        "r2@uni,Rolf Two,R2,Rem,active",
        "r3@uni.example,=Rosa,R3,Rem,active",
        "r4@uni.example,Rudi Four,R4,Rem,on leave",
    ];
    assert_eq!(leaving(&most.join("\n")), ["Ruth Five"]);
    for rolf in [
        "r2@uni,Somebody,,Rem,active",
        ",rolf  TWO,,Rem,active",
        "wrong,=x,r2,Rem,active",
        "r2@uni.example,,,Rem,",
        "r2@uni.example,Rolf Two,R2,Rem,\nr2@uni.example,Another Name,,Rem,",
    ] {
        assert!(!leaving(rolf).contains(&"Rolf Two".to_owned()), "{rolf}");
        assert_eq!(leaving(rolf).len(), 3, "{rolf}");
    }
}

#[test]
fn flags_of_suspended_and_deleted_accounts_are_read() {
    let file =
        |row: &str| format!("username,firstname,lastname,email,suspended,deleted\na,Ana,Ek,a@uni.example,{row}\n");
    let standing = |row: &str| entries(&file(row)).remove(0).standing;
    for (row, told) in [
        ("1,0", Some(AccountStanding::Gone)),
        ("0,1", Some(AccountStanding::Gone)),
        ("yes,", Some(AccountStanding::Gone)),
        ("0,0", Some(AccountStanding::Active)),
        (",0", None),
        (",", None),
    ] {
        assert_eq!(standing(row), told, "{row}");
    }
    assert_eq!(refusals(&file("perhaps,0")), [(2, Refusal::BadStatus("perhaps".to_owned()))]);
    assert!(read(file("0,0").as_bytes()).unwrap().ignored.is_empty());
}

#[test]
fn several_lines_about_one_person_are_read_together() {
    let file = "email,name,id,cohort\na@uni.example,Ana Ek,7,A\nb@uni.example,Bo,8,A\nA@uni.example,ana  ek,7,B\n";
    let roster = read(file.as_bytes()).unwrap();
    assert_eq!(roster.rows[0].entry.as_ref().unwrap().cohorts, ["A", "B"]);
    let outcomes = outcomes(file, &[], &RosterRequest::default());
    assert_eq!(outcomes, [RosterOutcome::New, RosterOutcome::New, RosterOutcome::Together(2)]);
    for other in ["a@uni.example,Bea Ek,7,B", "a@uni.example,Ana Ek,9,B", "a@uni.example,Ana Ek,8,B"] {
        let refused =
            refusals(&format!("email,name,id,cohort\na@uni.example,Ana Ek,7,A\nb@uni.example,Bo,8,A\n{other}\n"));
        assert_eq!(refused, [(4, Refusal::SameEmail(2))], "{other}");
    }
}

#[test]
fn section_lists_are_split_for_canvas_only() {
    let canvas = |section: &str| {
        entries(&format!(
            "Student,ID,SIS User ID,SIS Login ID,Section\n\"Lind, Ana\",1,U1,a@uni.example,\"{section}\"\n"
        ))
        .remove(0)
        .cohorts
    };
    assert_eq!(canvas("Anatomy A and Anatomy B"), ["Anatomy A", "Anatomy B"]);
    assert_eq!(canvas("Anatomy A, Anatomy B, and Anatomy C"), ["Anatomy A", "Anatomy B", "Anatomy C"]);
    assert_eq!(canvas("Anatomie A und Anatomie B"), ["Anatomie A", "Anatomie B"]);
    assert_eq!(canvas("Anatomy A"), ["Anatomy A"]);
    assert_eq!(canvas("Anatomy, Monday"), ["Anatomy, Monday"]);
    assert_eq!(entries("email,name,section\na@uni.example,A,Arts and Crafts\n").remove(0).cohorts, ["Arts and Crafts"]);
}

#[test]
fn what_looks_the_same_is_the_same() {
    let file = "email,name,id,cohort\njo\u{308}rg@uni.example,Jo\u{308}rg\u{a0} Ek,u1,year  4\nb@uni.example,Bo,,YEAR 4\nc@uni.example,Cy,,New\nd@uni.example,Di,,new\n";
    let mut roster = read(file.as_bytes()).unwrap();
    let mut wanted = Some("YEAR 4".to_owned());
    roster.spell_cohorts(["Year 4".to_owned(), "Other".to_owned()], &mut wanted);
    let cohorts: Vec<_> = roster.rows.iter().map(|row| row.entry.as_ref().unwrap().cohorts.join(", ")).collect();
    assert_eq!(
        (cohorts.as_slice(), wanted.as_deref()),
        (&["Year 4", "Year 4", "New", "New"].map(str::to_owned)[..], Some("Year 4"))
    );
    let jorg = SchoolPerson { name: "Jörg Ek".to_owned(), ..known(1, Some("U1"), "jörg@uni.example", &["Year 4"]) };
    let difference = RosterDifference::of(&roster, &[jorg], &RosterRequest::default());
    assert_eq!(difference.lines[0].outcome, RosterOutcome::Unchanged);
}

#[test]
fn addresses_are_read_in_their_one_spelling() {
    let file = "email,name\nzw\u{200b}@uni.example,A\nshy\u{ad}@uni.example,B\nmailto:mm@uni.example,C\nana@XN--MNCHEN-3YA.example,D\n\
                bom@uni.example,\u{feff}E\n";
    let emails: Vec<_> = entries(file).into_iter().map(|entry| entry.email).collect();
    assert_eq!(
        emails,
        ["zw@uni.example", "shy@uni.example", "mm@uni.example", "ana@münchen.example", "bom@uni.example"]
    );
    for bad in
        ["a..b@uni.example", "abc.@uni.example", "a:b@uni.example", "Ada <ada@uni.example>", "a\u{a0}b@uni.example"]
    {
        assert!(matches!(refusals(&format!("email,name\n{bad},A\n"))[..], [(2, Refusal::BadEmail(_))]), "{bad}");
    }
    assert!(matches!(refusals("email,name\na1@uni.example; a2@uni.example,A\n")[..], [(2, Refusal::BadEmail(_))]));
}

#[test]
fn an_open_quote_refuses_the_file_at_its_line() {
    let file =
        "email,name,cohort\nq1@uni.example,Quentin One,Q\nq3@uni.example,\"Quiz Three,Q\nq4@uni.example,Quax Four,Q\n";
    assert_eq!(read(file.as_bytes()), Err(Unreadable::OpenQuote { line: 3 }));
    let told = read(format!("sep=,\r\n{}", file.replace('\n', "\r\n")).as_bytes());
    assert_eq!(told, Err(Unreadable::OpenQuote { line: 4 }));
}
