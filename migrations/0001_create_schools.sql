-- Schools and the people in them. Every later table names its school, and its foreign keys carry the
-- school along, so that a row can never point into another school.
CREATE TABLE schools (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    name TEXT NOT NULL UNIQUE,
    created_at INTEGER NOT NULL -- µs since 1970 UTC, as every *_at
) STRICT;

CREATE TABLE people (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    role TEXT NOT NULL CHECK (role IN ('trainee', 'instructor', 'administrator')),
    email TEXT NOT NULL UNIQUE CHECK (email = lower(email)),
    display_name TEXT NOT NULL,
    pseudonym TEXT NOT NULL, -- what recordings say instead of a name
    password_hash TEXT NOT NULL,
    credential_version INTEGER NOT NULL DEFAULT 1, -- grows with each new password and ends older sign-ins
    disabled_at INTEGER,
    created_at INTEGER NOT NULL,
    UNIQUE (school_id, id),
    UNIQUE (school_id, pseudonym)
) STRICT;

CREATE TABLE cohorts (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    name TEXT NOT NULL,
    created_at INTEGER NOT NULL,
    UNIQUE (school_id, id),
    UNIQUE (school_id, name)
) STRICT;

CREATE TABLE cohort_members (
    school_id BLOB NOT NULL,
    cohort_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    role TEXT NOT NULL CHECK (role IN ('instructor', 'trainee')),
    PRIMARY KEY (cohort_id, person_id),
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX cohort_members_by_person ON cohort_members (person_id, role, cohort_id);
