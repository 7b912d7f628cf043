-- Experts' consent with its words and its history: what was agreed to, when, who recorded it, and when it was taken back.
-- The rows of before had no words of their own; what they were asked is told by how the consent was given.
CREATE TABLE expert_declarations (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    wording TEXT NOT NULL CHECK (length(trim(wording)) > 0), -- what was agreed to
    how TEXT NOT NULL CHECK (length(trim(how)) > 0), -- how it was given
    given_at INTEGER NOT NULL,
    recorded_by BLOB NOT NULL, -- themselves, or the administrator to whom they gave it
    withdrawn_at INTEGER,
    withdrawn_by BLOB,
    CHECK ((withdrawn_at IS NULL) = (withdrawn_by IS NULL)),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, recorded_by) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, withdrawn_by) REFERENCES people (school_id, id)
) STRICT;

CREATE UNIQUE INDEX expert_declarations_that_stand ON expert_declarations (school_id, person_id)
WHERE withdrawn_at IS NULL;
CREATE INDEX expert_declarations_by_person ON expert_declarations (school_id, person_id, given_at);

INSERT INTO expert_declarations (id, school_id, person_id, wording, how, given_at, recorded_by)
SELECT randomblob(16), school_id, person_id,
    'My own passed attempts may be part of the experts'' corridor, unnamed, and never among fewer than five.',
    note, given_at, recorded_by
FROM expert_consents;

DROP TABLE expert_consents;
