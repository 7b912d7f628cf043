-- Badges for mastered courses. A row stays when its badge is revoked: its place in the status lists is never given to another one.
CREATE TABLE badges (
    place BIGINT PRIMARY KEY CHECK (place >= 0), -- 131072 to a list
    id UUID NOT NULL UNIQUE,
    school_id UUID NOT NULL REFERENCES schools (id),
    person_id UUID NOT NULL,
    curriculum_id TEXT COLLATE "C" NOT NULL,
    curriculum_sha256 TEXT COLLATE "C" NOT NULL, -- of the revision that was mastered
    needed TEXT COLLATE "C" NOT NULL CHECK (needed IN ('nothing', 'resimulated', 'signed_or_supervised', 'supervised')), -- evidence of the attempts
    issued_at BIGINT NOT NULL,
    revoked_at BIGINT, -- for good
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
);

CREATE INDEX badges_by_person ON badges (school_id, person_id);
CREATE UNIQUE INDEX badges_that_stand ON badges (school_id, person_id, curriculum_sha256, needed) WHERE revoked_at IS NULL;
