// A stranger's reader: npm's MCAP reader and protobuf, and nothing of ours. Prints what it finds as JSON.
import { open } from "node:fs/promises";
import { McapIndexedReader } from "@mcap/core";
import { decompress } from "fzstd";
import protobuf from "protobufjs";
import "protobufjs/ext/descriptor/index.js";

const file = await open(process.argv[2], "r");
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, length) => {
    const buffer = new Uint8Array(Number(length));
    await file.read(buffer, 0, Number(length), Number(offset));
    return buffer;
  },
};
const decompressHandlers = { zstd: (data, size) => decompress(data, new Uint8Array(Number(size))) };
const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });

const types = new Map();
for (const channel of reader.channelsById.values()) {
  const schema = reader.schemasById.get(channel.schemaId);
  const root = protobuf.Root.fromDescriptor(schema.data);
  types.set(channel.id, { topic: channel.topic, type: root.lookupType(schema.name) });
}

const found = { metadata: {}, counts: {}, first_log_time: {}, transforms: {}, samples: {} };
for await (const record of reader.readMetadata()) {
  found.metadata[record.name] = Object.fromEntries(record.metadata);
}
found.attachments = reader.attachmentIndexes.map((index) => index.name);
for await (const message of reader.readMessages()) {
  const { topic, type } = types.get(message.channelId);
  const decoded = type.toObject(type.decode(message.data), { longs: String, bytes: String, defaults: true });
  found.counts[topic] = (found.counts[topic] ?? 0) + 1;
  found.first_log_time[topic] ??= message.logTime.toString();
  found.samples[topic] ??= decoded;
  for (const item of topic === "/tf" ? decoded.transforms : []) {
    const { x, y, z } = item.translation;
    found.transforms[item.child_frame_id] = [item.parent_frame_id, x, y, z];
  }
}
await file.close();
process.stdout.write(JSON.stringify(found));
