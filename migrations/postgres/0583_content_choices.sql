-- A choice of content for a course of a learning platform (LTI Deep Linking 2.0); its answer deletes it.
CREATE TABLE content_choices (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    platform_id UUID NOT NULL,
    deployment_id TEXT COLLATE "C" NOT NULL,
    issuer TEXT COLLATE "C" NOT NULL, -- with the subject: the identity that may answer
    subject TEXT COLLATE "C" NOT NULL,
    return_url TEXT COLLATE "C" NOT NULL,
    data TEXT COLLATE "C", -- of the platform, returned unchanged
    accepts_several BOOLEAN NOT NULL,
    accepts_line_items BOOLEAN NOT NULL,
    expires_at BIGINT NOT NULL,
    FOREIGN KEY (school_id, platform_id, deployment_id) REFERENCES platform_deployments (school_id, platform_id, deployment_id)
);

CREATE INDEX content_choices_by_end ON content_choices (expires_at);
CREATE INDEX content_choices_by_deployment ON content_choices (school_id, platform_id, deployment_id);
CREATE INDEX content_choices_by_identity ON content_choices (school_id, issuer, subject);
