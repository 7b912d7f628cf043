-- How long a school keeps whoever does nothing any more. NULL: for ever.
ALTER TABLE schools ADD COLUMN retention_months INTEGER CHECK (retention_months BETWEEN 3 AND 240);
ALTER TABLE schools ADD COLUMN retention_warn_days INTEGER NOT NULL DEFAULT 30 CHECK (retention_warn_days BETWEEN 7 AND 365);
ALTER TABLE schools ADD COLUMN retention_texts INTEGER NOT NULL DEFAULT 0 CHECK (retention_texts IN (0, 1)); -- their free texts go too

-- Since when somebody is kept whatever that rule says, as the law may ask.
ALTER TABLE people ADD COLUMN held_at INTEGER;

-- How long the service has run, whatever its clock was set to meanwhile, in s; and at which of them it last looked whom to erase.
CREATE TABLE service_time (
    id INTEGER PRIMARY KEY CHECK (id = 1),
    observed_s INTEGER NOT NULL,
    looked_s INTEGER
) STRICT;

INSERT INTO service_time (id, observed_s) VALUES (1, 0);

CREATE TABLE retention_warnings (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16), -- also of the letter
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL UNIQUE,
    active_at INTEGER NOT NULL, -- when they had last done anything
    warned_at INTEGER NOT NULL,
    tries INTEGER NOT NULL DEFAULT 0,
    next_run_at INTEGER, -- of the letter; absent: it is out, or given up
    told_at INTEGER, -- when it was
    told_observed_s INTEGER, -- the same by service_time
    error TEXT,
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    CHECK ((told_at IS NULL) = (told_observed_s IS NULL))
) STRICT;

CREATE INDEX retention_warnings_by_time ON retention_warnings (next_run_at) WHERE next_run_at IS NOT NULL;
CREATE INDEX retention_warnings_by_school ON retention_warnings (school_id);
CREATE INDEX people_held ON people (school_id, held_at) WHERE held_at IS NOT NULL;
