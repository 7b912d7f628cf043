-- Sign-in with a school's own account: OpenID Connect providers, the identities that they have confirmed, and pending sign-ins.
CREATE TABLE sign_in_providers (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    name TEXT NOT NULL,
    issuer TEXT NOT NULL,
    client_id TEXT NOT NULL,
    client_secret_sealed BLOB NOT NULL, -- opens with the key file, for this row only
    scopes TEXT NOT NULL,
    subject_claim TEXT NOT NULL DEFAULT 'sub',
    match_claim TEXT, -- compared with the registration number
    addresses_verified INTEGER NOT NULL DEFAULT 0 CHECK (addresses_verified IN (0, 1)),
    second_factor_trusted INTEGER NOT NULL DEFAULT 0 CHECK (second_factor_trusted IN (0, 1)),
    creates TEXT CHECK (creates IN ('trainee')), -- absent: accounts are created here first
    role_claim TEXT,
    role_map TEXT NOT NULL DEFAULT '{}', -- JSON: value of the claim to role
    made_at INTEGER NOT NULL,
    disabled_at INTEGER,
    UNIQUE (school_id, id),
    UNIQUE (school_id, issuer, client_id)
) STRICT;

CREATE TABLE identities (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    kind TEXT NOT NULL CHECK (kind IN ('oidc', 'lti')),
    issuer TEXT NOT NULL,
    subject TEXT NOT NULL,
    made_at INTEGER NOT NULL,
    made_by BLOB, -- absent: the sign-in itself
    how TEXT NOT NULL CHECK (how IN ('created', 'matched', 'joined', 'by_administrator')),
    last_used_at INTEGER,
    UNIQUE (school_id, kind, issuer, subject),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX identities_by_person ON identities (school_id, person_id);
CREATE INDEX identities_by_maker ON identities (school_id, made_by);

-- A sign-in at a provider that has not come back yet; its first answer deletes it.
CREATE TABLE sign_in_flows (
    state_sha256 BLOB PRIMARY KEY NOT NULL CHECK (length(state_sha256) = 32),
    school_id BLOB NOT NULL,
    provider_id BLOB NOT NULL,
    browser_sha256 BLOB NOT NULL CHECK (length(browser_sha256) = 32),
    nonce_sha256 BLOB NOT NULL CHECK (length(nonce_sha256) = 32),
    pkce_sealed BLOB NOT NULL,
    purpose TEXT NOT NULL CHECK (purpose IN ('enter', 'join', 'prove', 'try')),
    person_id BLOB,
    next TEXT NOT NULL,
    expires_at INTEGER NOT NULL,
    FOREIGN KEY (school_id, provider_id) REFERENCES sign_in_providers (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX sign_in_flows_by_end ON sign_in_flows (expires_at);
CREATE INDEX sign_in_flows_by_provider ON sign_in_flows (school_id, provider_id);
CREATE INDEX sign_in_flows_by_person ON sign_in_flows (school_id, person_id);

-- Documents of providers: their description and their keys, as fetched.
CREATE TABLE provider_documents (
    url_sha256 BLOB PRIMARY KEY NOT NULL CHECK (length(url_sha256) = 32),
    url TEXT NOT NULL,
    body TEXT NOT NULL,
    fetched_at INTEGER NOT NULL
) STRICT;

-- Who may sign in with a password of this service: everybody, or administrators alone.
ALTER TABLE schools ADD COLUMN local_passwords TEXT NOT NULL DEFAULT 'everybody' CHECK (local_passwords IN ('everybody', 'administrators'));

-- A mail may report that an account was joined: the same table with one more kind.
CREATE TABLE mails_again (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    kind TEXT NOT NULL CHECK (kind IN ('invitation', 'reset', 'reminder', 'second_factor_off', 'news', 'identity_joined')),
    assignment_id BLOB, -- of a reminder
    tries INTEGER NOT NULL DEFAULT 0,
    next_run_at INTEGER, -- absent: sent, or given up
    sent_at INTEGER,
    error TEXT,
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    CHECK ((kind = 'reminder') = (assignment_id IS NOT NULL))
) STRICT;

INSERT INTO mails_again (id, school_id, person_id, kind, assignment_id, tries, next_run_at, sent_at, error)
SELECT id, school_id, person_id, kind, assignment_id, tries, next_run_at, sent_at, error FROM mails;
DROP TABLE mails;
ALTER TABLE mails_again RENAME TO mails;

CREATE INDEX mails_by_time ON mails (next_run_at) WHERE next_run_at IS NOT NULL;
CREATE INDEX mails_by_person ON mails (school_id, person_id);
-- Each reminder once.
CREATE UNIQUE INDEX reminders_once ON mails (assignment_id, person_id) WHERE assignment_id IS NOT NULL;
CREATE INDEX mails_failed ON mails (school_id, id) WHERE error IS NOT NULL AND sent_at IS NULL;
