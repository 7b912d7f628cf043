-- Documents as they were published. A revision never changes; `exercises` and `curricula` point at the current one.
CREATE TABLE exercise_revisions (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    exercise_id TEXT NOT NULL,
    title TEXT NOT NULL,
    difficulty INTEGER NOT NULL,
    pass_mark REAL NOT NULL, -- 0–100
    exercise_sha256 TEXT NOT NULL,
    scene_sha256 TEXT NOT NULL,
    bundle_sha256 TEXT NOT NULL, -- over the exercise, its scene and every mesh
    exercise_bytes BLOB NOT NULL,
    scene_bytes BLOB NOT NULL,
    published_at INTEGER NOT NULL,
    UNIQUE (school_id, id),
    UNIQUE (school_id, bundle_sha256)
) STRICT;

CREATE INDEX exercise_revisions_by_sha ON exercise_revisions (school_id, exercise_sha256, scene_sha256);

CREATE TABLE exercise_meshes (
    revision_id BLOB NOT NULL REFERENCES exercise_revisions (id),
    position INTEGER NOT NULL,
    name TEXT NOT NULL,
    bytes BLOB NOT NULL,
    PRIMARY KEY (revision_id, position)
) STRICT;

CREATE TABLE exercises (
    school_id BLOB NOT NULL REFERENCES schools (id),
    exercise_id TEXT NOT NULL,
    revision_id BLOB NOT NULL,
    PRIMARY KEY (school_id, exercise_id),
    FOREIGN KEY (school_id, revision_id) REFERENCES exercise_revisions (school_id, id)
) STRICT;

CREATE TABLE curriculum_revisions (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    curriculum_id TEXT NOT NULL,
    title TEXT NOT NULL,
    description TEXT NOT NULL,
    mastery_passes INTEGER NOT NULL, -- passes of the last `mastery_of` attempts
    mastery_of INTEGER NOT NULL,
    sha256 TEXT NOT NULL,
    bytes BLOB NOT NULL,
    published_at INTEGER NOT NULL,
    UNIQUE (school_id, id),
    UNIQUE (school_id, sha256)
) STRICT;

CREATE TABLE curriculum_entries (
    revision_id BLOB NOT NULL REFERENCES curriculum_revisions (id),
    position INTEGER NOT NULL,
    exercise_id TEXT NOT NULL,
    prerequisites TEXT NOT NULL, -- JSON: array of exercise ids
    survey TEXT,
    PRIMARY KEY (revision_id, position)
) STRICT;

CREATE TABLE curricula (
    school_id BLOB NOT NULL REFERENCES schools (id),
    curriculum_id TEXT NOT NULL,
    revision_id BLOB NOT NULL,
    PRIMARY KEY (school_id, curriculum_id),
    FOREIGN KEY (school_id, revision_id) REFERENCES curriculum_revisions (school_id, id)
) STRICT;

CREATE TRIGGER exercise_revisions_never_change BEFORE UPDATE ON exercise_revisions
BEGIN SELECT RAISE(ABORT, 'a published exercise revision never changes'); END;
CREATE TRIGGER exercise_revisions_never_go BEFORE DELETE ON exercise_revisions
BEGIN SELECT RAISE(ABORT, 'a published exercise revision is never deleted'); END;
CREATE TRIGGER exercise_meshes_never_change BEFORE UPDATE ON exercise_meshes
BEGIN SELECT RAISE(ABORT, 'a published mesh never changes'); END;
CREATE TRIGGER exercise_meshes_never_go BEFORE DELETE ON exercise_meshes
BEGIN SELECT RAISE(ABORT, 'a published mesh is never deleted'); END;
CREATE TRIGGER curriculum_revisions_never_change BEFORE UPDATE ON curriculum_revisions
BEGIN SELECT RAISE(ABORT, 'a published curriculum revision never changes'); END;
CREATE TRIGGER curriculum_revisions_never_go BEFORE DELETE ON curriculum_revisions
BEGIN SELECT RAISE(ABORT, 'a published curriculum revision is never deleted'); END;
