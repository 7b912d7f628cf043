-- Documents being written. A draft becomes a revision when it is published; until then no trainee is given it.
CREATE TABLE drafts (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    kind TEXT NOT NULL CHECK (kind IN ('exercise', 'course')),
    document_id TEXT NOT NULL, -- of what it will be a revision
    based_on BLOB, -- the revision of an exercise that its meshes come from
    document TEXT NOT NULL, -- TOML
    scene TEXT NOT NULL, -- TOML, of an exercise; empty for a course
    version INTEGER NOT NULL, -- grows with each save: a save names the one it has seen
    saved_by BLOB NOT NULL,
    saved_at INTEGER NOT NULL,
    UNIQUE (school_id, kind, document_id),
    FOREIGN KEY (school_id, based_on) REFERENCES exercise_revisions (school_id, id),
    FOREIGN KEY (school_id, saved_by) REFERENCES people (school_id, id)
) STRICT;

-- What the pages that compare revisions ask for.
CREATE INDEX exercise_revisions_by_exercise ON exercise_revisions (school_id, exercise_id, published_at);
CREATE INDEX curriculum_revisions_by_curriculum ON curriculum_revisions (school_id, curriculum_id, published_at);
