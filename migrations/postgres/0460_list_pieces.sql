-- Where recordings lie in a bucket, the pieces of an upload are objects of their own; this says which, and in which order. What
-- lies beside them was never counted.
CREATE TABLE upload_pieces (
    upload_id UUID NOT NULL REFERENCES uploads (id) ON DELETE CASCADE,
    begins BIGINT NOT NULL CHECK (begins >= 0), -- in bytes
    object TEXT COLLATE "C" NOT NULL, -- its name in the bucket
    PRIMARY KEY (upload_id, begins)
);
