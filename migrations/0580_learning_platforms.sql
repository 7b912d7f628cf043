-- Launches from learning platforms (LTI 1.3): registrations, their deployments, contexts and links, and launches that have not come back yet.
CREATE TABLE platforms (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    name TEXT NOT NULL,
    issuer TEXT NOT NULL,
    client_id TEXT NOT NULL,
    auth_url TEXT NOT NULL,
    token_url TEXT NOT NULL,
    keys_url TEXT NOT NULL,
    token_audience TEXT, -- absent: token_url
    number_claim TEXT CHECK (number_claim IN ('person_sourcedid', 'student_number')), -- compared with the registration number
    creates TEXT CHECK (creates IN ('trainee')), -- absent: accounts are created here first
    made_at INTEGER NOT NULL,
    disabled_at INTEGER,
    UNIQUE (school_id, id),
    UNIQUE (issuer, client_id) -- over the service: a launch names no school
) STRICT;

CREATE TABLE platform_deployments (
    platform_id BLOB NOT NULL,
    deployment_id TEXT NOT NULL, -- as the platform names it
    school_id BLOB NOT NULL,
    first_seen_at INTEGER NOT NULL,
    admitted_at INTEGER, -- absent: its launches are refused
    PRIMARY KEY (platform_id, deployment_id),
    UNIQUE (school_id, platform_id, deployment_id),
    FOREIGN KEY (school_id, platform_id) REFERENCES platforms (school_id, id)
) STRICT;

-- A course of the platform.
CREATE TABLE platform_contexts (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    platform_id BLOB NOT NULL,
    deployment_id TEXT NOT NULL,
    context_id TEXT NOT NULL, -- as the platform names it
    title TEXT,
    members_url TEXT,
    lineitems_url TEXT,
    seen_at INTEGER NOT NULL,
    UNIQUE (school_id, id),
    UNIQUE (school_id, platform_id, deployment_id, context_id),
    FOREIGN KEY (school_id, platform_id, deployment_id) REFERENCES platform_deployments (school_id, platform_id, deployment_id)
) STRICT;

-- A place in the platform that leads here.
CREATE TABLE platform_links (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    platform_id BLOB NOT NULL,
    deployment_id TEXT NOT NULL,
    context_id BLOB, -- absent: outside of a course
    resource_link_id TEXT NOT NULL, -- as the platform names it
    page TEXT NOT NULL, -- the path that it opens
    lineitem_url TEXT,
    made_at INTEGER NOT NULL,
    UNIQUE (school_id, platform_id, deployment_id, resource_link_id),
    FOREIGN KEY (school_id, platform_id, deployment_id) REFERENCES platform_deployments (school_id, platform_id, deployment_id),
    FOREIGN KEY (school_id, context_id) REFERENCES platform_contexts (school_id, id)
) STRICT;

CREATE INDEX platform_links_by_context ON platform_links (school_id, context_id);

-- A launch that the platform has not confirmed yet; its first answer deletes it.
CREATE TABLE launches (
    state_sha256 BLOB PRIMARY KEY NOT NULL CHECK (length(state_sha256) = 32),
    school_id BLOB NOT NULL,
    platform_id BLOB NOT NULL,
    browser_sha256 BLOB NOT NULL CHECK (length(browser_sha256) = 32),
    nonce_sha256 BLOB NOT NULL CHECK (length(nonce_sha256) = 32),
    login_hint TEXT NOT NULL,
    message_hint TEXT,
    target_link_uri TEXT NOT NULL,
    expires_at INTEGER NOT NULL,
    FOREIGN KEY (school_id, platform_id) REFERENCES platforms (school_id, id)
) STRICT;

CREATE INDEX launches_by_end ON launches (expires_at);
CREATE INDEX launches_by_platform ON launches (school_id, platform_id);
