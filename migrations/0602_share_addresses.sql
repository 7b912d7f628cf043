-- no-transaction
-- An email address belongs to one account of a school, no longer to one of the service: an administrator who adds an address must not
-- learn whether another school has it. SQLite cannot drop a UNIQUE constraint, so the table is made anew as its manual describes
-- (https://www.sqlite.org/lang_altertable.html#otheralter); the foreign keys of other tables keep naming it.
PRAGMA foreign_keys = OFF;
PRAGMA legacy_alter_table = ON;
BEGIN IMMEDIATE;
CREATE TABLE people_anew (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    email TEXT NOT NULL CHECK (email = lower(email)),
    display_name TEXT NOT NULL,
    pseudonym TEXT NOT NULL, -- what recordings contain instead of a name
    password_hash TEXT NOT NULL,
    credential_version INTEGER NOT NULL DEFAULT 1, -- grows with each new password and ends older sign-ins
    disabled_at INTEGER,
    created_at INTEGER NOT NULL,
    registrar_id TEXT,
    erased_at INTEGER,
    search TEXT NOT NULL DEFAULT '',
    language TEXT CHECK (length(language) BETWEEN 2 AND 16),
    held_at INTEGER,
    password_initial_until INTEGER,
    role TEXT NOT NULL DEFAULT 'trainee' CHECK (role IN ('trainee', 'instructor', 'administrator', 'guest')),
    mail_news INTEGER NOT NULL DEFAULT 1 CHECK (mail_news IN (0, 1)),
    sort_name TEXT NOT NULL DEFAULT '',
    sort_number TEXT GENERATED ALWAYS AS (coalesce(registrar_id, '')) VIRTUAL,
    practised_at INTEGER,
    UNIQUE (school_id, id),
    UNIQUE (school_id, pseudonym),
    UNIQUE (school_id, email)
) STRICT;
INSERT INTO people_anew (id, school_id, email, display_name, pseudonym, password_hash, credential_version, disabled_at, created_at,
    registrar_id, erased_at, search, language, held_at, password_initial_until, role, mail_news, sort_name, practised_at)
SELECT id, school_id, email, display_name, pseudonym, password_hash, credential_version, disabled_at, created_at,
    registrar_id, erased_at, search, language, held_at, password_initial_until, role, mail_news, sort_name, practised_at
FROM people;
DROP TABLE people;
ALTER TABLE people_anew RENAME TO people;
CREATE UNIQUE INDEX people_by_registrar ON people (school_id, registrar_id) WHERE registrar_id IS NOT NULL;
CREATE INDEX people_by_name ON people (school_id, display_name, id);
CREATE INDEX people_held ON people (school_id, held_at) WHERE held_at IS NOT NULL;
CREATE INDEX people_by_role ON people (school_id, role) WHERE disabled_at IS NULL;
CREATE INDEX people_who_teach ON people (school_id, display_name, id)
WHERE role = 'instructor' AND disabled_at IS NULL AND erased_at IS NULL;
CREATE INDEX people_by_sort_name ON people (school_id, sort_name, id);
CREATE INDEX people_by_email ON people (email);
CREATE INDEX people_by_address ON people (school_id, email, id);
CREATE INDEX people_by_number ON people (school_id, sort_number, id);
CREATE INDEX people_unsorted ON people (id) WHERE sort_name = '' AND role <> 'guest';
CREATE INDEX people_by_practice ON people (school_id, practised_at) WHERE practised_at IS NOT NULL;
COMMIT;
PRAGMA legacy_alter_table = OFF;
PRAGMA foreign_keys = ON;
