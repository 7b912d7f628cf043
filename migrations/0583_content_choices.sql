-- A choice of content for a course of a learning platform (LTI Deep Linking 2.0); its answer deletes it.
CREATE TABLE content_choices (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    platform_id BLOB NOT NULL,
    deployment_id TEXT NOT NULL,
    issuer TEXT NOT NULL, -- with the subject: the identity that may answer
    subject TEXT NOT NULL,
    return_url TEXT NOT NULL,
    data TEXT, -- of the platform, returned unchanged
    accepts_several INTEGER NOT NULL CHECK (accepts_several IN (0, 1)),
    accepts_line_items INTEGER NOT NULL CHECK (accepts_line_items IN (0, 1)),
    expires_at INTEGER NOT NULL,
    FOREIGN KEY (school_id, platform_id, deployment_id) REFERENCES platform_deployments (school_id, platform_id, deployment_id)
) STRICT;

CREATE INDEX content_choices_by_end ON content_choices (expires_at);
CREATE INDEX content_choices_by_deployment ON content_choices (school_id, platform_id, deployment_id);
CREATE INDEX content_choices_by_identity ON content_choices (school_id, issuer, subject);
