-- Provisioning by SCIM 2.0: tokens of directories, and what they call people and cohorts.
CREATE TABLE provisioning_tokens (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    name TEXT NOT NULL,
    token_sha256 BLOB NOT NULL UNIQUE CHECK (length(token_sha256) = 32),
    may_disable_staff INTEGER NOT NULL DEFAULT 0 CHECK (may_disable_staff IN (0, 1)),
    made_at INTEGER NOT NULL,
    expires_at INTEGER NOT NULL,
    last_used_at INTEGER, -- to the hour
    revoked_at INTEGER
) STRICT;

CREATE INDEX provisioning_tokens_by_school ON provisioning_tokens (school_id);

CREATE TABLE provisioned_people (
    person_id BLOB PRIMARY KEY NOT NULL,
    school_id BLOB NOT NULL,
    user_name TEXT NOT NULL,
    user_name_key TEXT NOT NULL, -- in lower case, by which it is found
    deleted_at INTEGER, -- since when the directory no longer has them
    UNIQUE (school_id, user_name_key),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX provisioned_people_by_person ON provisioned_people (school_id, person_id);

CREATE TABLE provisioned_cohorts (
    cohort_id BLOB PRIMARY KEY NOT NULL,
    school_id BLOB NOT NULL,
    external_id TEXT,
    deleted_at INTEGER,
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id)
) STRICT;

CREATE INDEX provisioned_cohorts_by_cohort ON provisioned_cohorts (school_id, cohort_id);
