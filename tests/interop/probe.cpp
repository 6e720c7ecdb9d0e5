// A peer that shares no code with the plugin: Fast DDS with types built from an XML file, not from ours.
// For each line "NAME TYPE" of the topics file it takes every sample of rt/NAME apart into named fields, prints them, and
// puts the sample together again on rtecho/NAME.   probe DOMAIN TYPES.xml TOPICS.txt     Ends with its standard input.
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/types/DynamicDataFactory.h>
#include <fastrtps/types/DynamicDataHelper.hpp>
#include <fastrtps/types/DynamicPubSubType.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>

#include <fstream>
#include <iostream>
#include <memory>
#include <mutex>
#include <vector>

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::types::DynamicData;
using eprosima::fastrtps::types::DynamicData_ptr;
using eprosima::fastrtps::types::DynamicDataFactory;
using eprosima::fastrtps::types::DynamicDataHelper;
using eprosima::fastrtps::types::DynamicPubSubType;
using eprosima::fastrtps::types::DynamicType_ptr;
using eprosima::fastrtps::xmlparser::XMLProfileManager;

static std::mutex printing;

struct Echo : DataReaderListener {
    std::string name;
    DynamicType_ptr type;
    DataWriter* writer = nullptr;

    void on_data_available(DataReader* reader) override {
        DynamicData_ptr data(DynamicDataFactory::get_instance()->create_data(type));
        SampleInfo info;
        while (reader->take_next_sample(data.get(), &info) == ReturnCode_t::RETCODE_OK) {
            if (!info.valid_data) continue;
            std::lock_guard<std::mutex> lock(printing);
            std::cout << "== " << name << std::endl;
            DynamicDataHelper::print(data);
            std::cout << std::flush;
            writer->write(data.get());
        }
    }
};

int main(int argc, char** argv) {
    if (argc != 4) return 2;
    if (XMLProfileManager::loadXMLFile(argv[2]) != eprosima::fastrtps::xmlparser::XMLP_ret::XML_OK) return 3;
    DomainParticipantQos qos = PARTICIPANT_QOS_DEFAULT;
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList.push_back("127.0.0.1");
    udp->maxInitialPeersRange = 20;
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(udp);
    eprosima::fastrtps::rtps::Locator_t peer;
    eprosima::fastrtps::rtps::IPLocator::setIPv4(peer, "127.0.0.1");
    qos.wire_protocol().builtin.initialPeersList.push_back(peer);
    auto* participant = DomainParticipantFactory::get_instance()->create_participant(std::stoi(argv[1]), qos);
    if (participant == nullptr) return 4;
    auto* publisher = participant->create_publisher(PUBLISHER_QOS_DEFAULT);
    auto* subscriber = participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
    DataReaderQos in = DATAREADER_QOS_DEFAULT;
    in.reliability().kind = RELIABLE_RELIABILITY_QOS;
    in.history().kind = KEEP_ALL_HISTORY_QOS;
    DataWriterQos out = DATAWRITER_QOS_DEFAULT;
    out.history().kind = KEEP_ALL_HISTORY_QOS;
    out.endpoint().history_memory_policy = eprosima::fastrtps::rtps::DYNAMIC_RESERVE_MEMORY_MODE;
    in.endpoint().history_memory_policy = eprosima::fastrtps::rtps::DYNAMIC_RESERVE_MEMORY_MODE;
    std::vector<std::unique_ptr<Echo>> echoes;
    std::ifstream topics(argv[3]);
    std::string name, kind;
    while (topics >> name >> kind) {
        auto* builder = XMLProfileManager::getDynamicTypeByName(kind);
        if (builder == nullptr) { std::cerr << "no type " << kind << std::endl; return 5; }
        auto echo = std::make_unique<Echo>();
        echo->name = name;
        echo->type = builder->build();
        auto* pubsub = new DynamicPubSubType(echo->type);
        pubsub->auto_fill_type_information(false);
        pubsub->auto_fill_type_object(false);
        TypeSupport support(pubsub);
        if (participant->find_type(kind).empty()) support.register_type(participant);
        auto* there = participant->create_topic("rtecho" + name, kind, TOPIC_QOS_DEFAULT);
        auto* here = participant->create_topic("rt" + name, kind, TOPIC_QOS_DEFAULT);
        echo->writer = publisher->create_datawriter(there, out);
        if (echo->writer == nullptr || subscriber->create_datareader(here, in, echo.get()) == nullptr) return 6;
        echoes.push_back(std::move(echo));
    }
    std::cout << "ready" << std::endl;
    while (std::cin.get() != EOF) {}
    participant->delete_contained_entities();
    DomainParticipantFactory::get_instance()->delete_participant(participant);
    return 0;
}
