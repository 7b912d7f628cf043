-- Sign-in with a school's own account: OpenID Connect providers, the identities that they have confirmed, and pending sign-ins.
CREATE TABLE sign_in_providers (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    name TEXT COLLATE "C" NOT NULL,
    issuer TEXT COLLATE "C" NOT NULL,
    client_id TEXT COLLATE "C" NOT NULL,
    client_secret_sealed BYTEA NOT NULL, -- opens with the key file, for this row only
    scopes TEXT COLLATE "C" NOT NULL,
    subject_claim TEXT COLLATE "C" NOT NULL DEFAULT 'sub',
    match_claim TEXT COLLATE "C", -- compared with the registration number
    addresses_verified BOOLEAN NOT NULL DEFAULT FALSE,
    second_factor_trusted BOOLEAN NOT NULL DEFAULT FALSE,
    creates TEXT COLLATE "C" CHECK (creates IN ('trainee')), -- absent: accounts are created here first
    role_claim TEXT COLLATE "C",
    role_map TEXT COLLATE "C" NOT NULL DEFAULT '{}', -- JSON: value of the claim to role
    made_at BIGINT NOT NULL,
    disabled_at BIGINT,
    UNIQUE (school_id, id),
    UNIQUE (school_id, issuer, client_id)
);

CREATE TABLE identities (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    person_id UUID NOT NULL,
    kind TEXT COLLATE "C" NOT NULL CHECK (kind IN ('oidc', 'lti')),
    issuer TEXT COLLATE "C" NOT NULL,
    subject TEXT COLLATE "C" NOT NULL,
    made_at BIGINT NOT NULL,
    made_by UUID, -- absent: the sign-in itself
    how TEXT COLLATE "C" NOT NULL CHECK (how IN ('created', 'matched', 'joined', 'by_administrator')),
    last_used_at BIGINT,
    UNIQUE (school_id, kind, issuer, subject),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
);

CREATE INDEX identities_by_person ON identities (school_id, person_id);
CREATE INDEX identities_by_maker ON identities (school_id, made_by);

-- A sign-in at a provider that has not come back yet; its first answer deletes it.
CREATE TABLE sign_in_flows (
    state_sha256 BYTEA PRIMARY KEY CHECK (length(state_sha256) = 32),
    school_id UUID NOT NULL,
    provider_id UUID NOT NULL,
    browser_sha256 BYTEA NOT NULL CHECK (length(browser_sha256) = 32),
    nonce_sha256 BYTEA NOT NULL CHECK (length(nonce_sha256) = 32),
    pkce_sealed BYTEA NOT NULL,
    purpose TEXT COLLATE "C" NOT NULL CHECK (purpose IN ('enter', 'join', 'prove', 'try')),
    person_id UUID,
    next TEXT COLLATE "C" NOT NULL,
    expires_at BIGINT NOT NULL,
    FOREIGN KEY (school_id, provider_id) REFERENCES sign_in_providers (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
);

CREATE INDEX sign_in_flows_by_end ON sign_in_flows (expires_at);
CREATE INDEX sign_in_flows_by_provider ON sign_in_flows (school_id, provider_id);
CREATE INDEX sign_in_flows_by_person ON sign_in_flows (school_id, person_id);

-- Documents of providers: their description and their keys, as fetched.
CREATE TABLE provider_documents (
    url_sha256 BYTEA PRIMARY KEY CHECK (length(url_sha256) = 32),
    url TEXT COLLATE "C" NOT NULL,
    body TEXT COLLATE "C" NOT NULL,
    fetched_at BIGINT NOT NULL
);

-- Who may sign in with a password of this service: everybody, or administrators alone.
ALTER TABLE schools ADD COLUMN local_passwords TEXT COLLATE "C" NOT NULL DEFAULT 'everybody' CHECK (local_passwords IN ('everybody', 'administrators'));

-- A mail may report that an account was joined.
ALTER TABLE mails DROP CONSTRAINT mails_kind_check;
ALTER TABLE mails ADD CONSTRAINT mails_kind_check CHECK (kind IN ('invitation', 'reset', 'reminder', 'second_factor_off', 'news', 'identity_joined'));
