-- Badges for mastered courses. A row stays when its badge is revoked: its place in the status lists is never given to another one.
CREATE TABLE badges (
    place INTEGER PRIMARY KEY NOT NULL CHECK (place >= 0), -- 131072 to a list
    id BLOB NOT NULL UNIQUE CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    person_id BLOB NOT NULL,
    curriculum_id TEXT NOT NULL,
    curriculum_sha256 TEXT NOT NULL, -- of the revision that was mastered
    needed TEXT NOT NULL CHECK (needed IN ('nothing', 'resimulated', 'signed_or_supervised', 'supervised')), -- evidence of the attempts
    issued_at INTEGER NOT NULL,
    revoked_at INTEGER, -- for good
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX badges_by_person ON badges (school_id, person_id);
CREATE UNIQUE INDEX badges_that_stand ON badges (school_id, person_id, curriculum_sha256, needed) WHERE revoked_at IS NULL;
