-- Launches from learning platforms (LTI 1.3): registrations, their deployments, contexts and links, and launches that have not come back yet.
CREATE TABLE platforms (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    name TEXT COLLATE "C" NOT NULL,
    issuer TEXT COLLATE "C" NOT NULL,
    client_id TEXT COLLATE "C" NOT NULL,
    auth_url TEXT COLLATE "C" NOT NULL,
    token_url TEXT COLLATE "C" NOT NULL,
    keys_url TEXT COLLATE "C" NOT NULL,
    token_audience TEXT COLLATE "C", -- absent: token_url
    number_claim TEXT COLLATE "C" CHECK (number_claim IN ('person_sourcedid', 'student_number')), -- compared with the registration number
    creates TEXT COLLATE "C" CHECK (creates IN ('trainee')), -- absent: accounts are created here first
    made_at BIGINT NOT NULL,
    disabled_at BIGINT,
    UNIQUE (school_id, id),
    UNIQUE (issuer, client_id) -- over the service: a launch names no school
);

CREATE TABLE platform_deployments (
    platform_id UUID NOT NULL,
    deployment_id TEXT COLLATE "C" NOT NULL, -- as the platform names it
    school_id UUID NOT NULL,
    first_seen_at BIGINT NOT NULL,
    admitted_at BIGINT, -- absent: its launches are refused
    PRIMARY KEY (platform_id, deployment_id),
    UNIQUE (school_id, platform_id, deployment_id),
    FOREIGN KEY (school_id, platform_id) REFERENCES platforms (school_id, id)
);

-- A course of the platform.
CREATE TABLE platform_contexts (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    platform_id UUID NOT NULL,
    deployment_id TEXT COLLATE "C" NOT NULL,
    context_id TEXT COLLATE "C" NOT NULL, -- as the platform names it
    title TEXT COLLATE "C",
    members_url TEXT COLLATE "C",
    lineitems_url TEXT COLLATE "C",
    seen_at BIGINT NOT NULL,
    UNIQUE (school_id, id),
    UNIQUE (school_id, platform_id, deployment_id, context_id),
    FOREIGN KEY (school_id, platform_id, deployment_id) REFERENCES platform_deployments (school_id, platform_id, deployment_id)
);

-- A place in the platform that leads here.
CREATE TABLE platform_links (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    platform_id UUID NOT NULL,
    deployment_id TEXT COLLATE "C" NOT NULL,
    context_id UUID, -- absent: outside of a course
    resource_link_id TEXT COLLATE "C" NOT NULL, -- as the platform names it
    page TEXT COLLATE "C" NOT NULL, -- the path that it opens
    lineitem_url TEXT COLLATE "C",
    made_at BIGINT NOT NULL,
    UNIQUE (school_id, platform_id, deployment_id, resource_link_id),
    FOREIGN KEY (school_id, platform_id, deployment_id) REFERENCES platform_deployments (school_id, platform_id, deployment_id),
    FOREIGN KEY (school_id, context_id) REFERENCES platform_contexts (school_id, id)
);

CREATE INDEX platform_links_by_context ON platform_links (school_id, context_id);

-- A launch that the platform has not confirmed yet; its first answer deletes it.
CREATE TABLE launches (
    state_sha256 BYTEA PRIMARY KEY CHECK (length(state_sha256) = 32),
    school_id UUID NOT NULL,
    platform_id UUID NOT NULL,
    browser_sha256 BYTEA NOT NULL CHECK (length(browser_sha256) = 32),
    nonce_sha256 BYTEA NOT NULL CHECK (length(nonce_sha256) = 32),
    login_hint TEXT COLLATE "C" NOT NULL,
    message_hint TEXT COLLATE "C",
    target_link_uri TEXT COLLATE "C" NOT NULL,
    expires_at BIGINT NOT NULL,
    FOREIGN KEY (school_id, platform_id) REFERENCES platforms (school_id, id)
);

CREATE INDEX launches_by_end ON launches (expires_at);
CREATE INDEX launches_by_platform ON launches (school_id, platform_id);
