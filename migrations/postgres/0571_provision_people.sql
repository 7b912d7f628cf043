-- Provisioning by SCIM 2.0: tokens of directories, and what they call people and cohorts.
CREATE TABLE provisioning_tokens (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    name TEXT COLLATE "C" NOT NULL,
    token_sha256 BYTEA NOT NULL UNIQUE CHECK (length(token_sha256) = 32),
    may_disable_staff BOOLEAN NOT NULL DEFAULT FALSE,
    made_at BIGINT NOT NULL,
    expires_at BIGINT NOT NULL,
    last_used_at BIGINT, -- to the hour
    revoked_at BIGINT
);

CREATE INDEX provisioning_tokens_by_school ON provisioning_tokens (school_id);

CREATE TABLE provisioned_people (
    person_id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    user_name TEXT COLLATE "C" NOT NULL,
    user_name_key TEXT COLLATE "C" NOT NULL, -- in lower case, by which it is found
    deleted_at BIGINT, -- since when the directory no longer has them
    UNIQUE (school_id, user_name_key),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
);

CREATE INDEX provisioned_people_by_person ON provisioned_people (school_id, person_id);

CREATE TABLE provisioned_cohorts (
    cohort_id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    external_id TEXT COLLATE "C",
    deleted_at BIGINT,
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id)
);

CREATE INDEX provisioned_cohorts_by_cohort ON provisioned_cohorts (school_id, cohort_id);
